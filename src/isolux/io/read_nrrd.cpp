#include <itkNrrdImageIO.h>

#include <cmath>
#include <limits>

#include "isolux/base/error.h"
#include "isolux/io/format.h"
#include "isolux/io/nrrd_header.h"

namespace isolux {
namespace {

bool recognises(const ReadRequest&, std::string_view first_bytes) {
  return first_bytes.starts_with("NRRD");
}

template <typename Stored, typename Voxel>
VoxelArray read_voxels(itk::ImageIOBase& io, std::size_t count) {
  std::vector<Stored> stored(count);
  io.Read(stored.data());
  if constexpr (std::is_same_v<Stored, Voxel>) {
    return stored;
  } else {
    return std::vector<Voxel>(stored.begin(), stored.end());
  }
}

VoxelArray read_any(itk::ImageIOBase& io, std::size_t count, ReadResult& result) {
  using itk::IOComponentEnum;
  const auto as_float = [&](const char* type) {
    result.notes.push_back(std::string(type) + " voxels are kept as 32-bit floats");
  };
  switch (io.GetComponentType()) {
    case IOComponentEnum::UCHAR: return read_voxels<std::uint8_t, std::uint8_t>(io, count);
    case IOComponentEnum::CHAR: return read_voxels<std::int8_t, std::int16_t>(io, count);
    case IOComponentEnum::SHORT: return read_voxels<std::int16_t, std::int16_t>(io, count);
    case IOComponentEnum::USHORT: return read_voxels<std::uint16_t, std::uint16_t>(io, count);
    case IOComponentEnum::FLOAT: return read_voxels<float, float>(io, count);
    case IOComponentEnum::INT: as_float("32-bit"); return read_voxels<std::int32_t, float>(io, count);
    case IOComponentEnum::UINT: as_float("32-bit"); return read_voxels<std::uint32_t, float>(io, count);
    case IOComponentEnum::LONG:
    case IOComponentEnum::LONGLONG:
      as_float("64-bit");
      return read_voxels<std::int64_t, float>(io, count);
    case IOComponentEnum::ULONG:
    case IOComponentEnum::ULONGLONG:
      as_float("64-bit");
      return read_voxels<std::uint64_t, float>(io, count);
    case IOComponentEnum::DOUBLE: as_float("64-bit"); return read_voxels<double, float>(io, count);
    default:
      throw WorkError(result.name, "its voxel type is not a number", "convert it first");
  }
}

// ITK carries NRRD's right-anterior-superior and left-anterior-superior spaces over to LPS.
Affine placement(const itk::ImageIOBase& io, const std::string& name) {
  Affine world_from_index;
  for (unsigned axis = 0; axis < std::min(3u, io.GetNumberOfDimensions()); ++axis) {
    const std::vector<double> along = io.GetDirection(axis);
    Vec3& column = world_from_index.linear.column[axis];
    column = Vec3{};
    for (unsigned row = 0; row < std::min<std::size_t>(3, along.size()); ++row) {
      column[static_cast<int>(row)] = along[row] * io.GetSpacing(axis);
    }
    world_from_index.offset[static_cast<int>(axis)] = io.GetOrigin(axis);
  }
  const double det = determinant(world_from_index.linear);
  if (!std::isfinite(det) || det == 0 || !is_finite(world_from_index.offset)) {
    throw WorkError(name, "its axes do not span space (spacing or directions are zero or not finite)",
                    "mend the header, or give --spacing for a raw file");
  }
  return world_from_index;
}

ReadResult read(const ReadRequest& request) {
  const NrrdHeader header = read_nrrd_header(request.name);
  ReadResult result{nullptr, request.name, "NRRD", {request.name}, {}};
  result.files.insert(result.files.end(), header.data_files.begin(), header.data_files.end());
  itk::Object::SetGlobalWarningDisplay(false);
  auto volume = std::make_shared<Volume>();
  try {
    const auto io = itk::NrrdImageIO::New();
    io->SetFileName(request.name);
    io->ReadImageInformation();
    if (io->GetNumberOfComponents() != 1) {
      throw WorkError(request.name,
                      "has " + std::to_string(io->GetNumberOfComponents()) + " values a voxel",
                      "isolux draws surfaces of one value; extract a channel first");
    }
    if (io->GetNumberOfDimensions() > 3) {
      throw WorkError(request.name,
                      "has " + std::to_string(io->GetNumberOfDimensions()) + " dimensions",
                      "this version reads volumes of three");
    }
    std::size_t count = 1;
    volume->dims = {1, 1, 1};
    for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
      if (io->GetDimensions(axis) > std::numeric_limits<int>::max() / 2) {
        throw WorkError(request.name, "is too long along an axis", "crop it first");
      }
      volume->dims[axis] = static_cast<int>(io->GetDimensions(axis));
      count *= io->GetDimensions(axis);
    }
    itk::ImageIORegion whole(io->GetNumberOfDimensions());
    for (unsigned axis = 0; axis < io->GetNumberOfDimensions(); ++axis) {
      whole.SetSize(axis, io->GetDimensions(axis));
    }
    io->SetIORegion(whole);
    volume->world_from_index = placement(*io, request.name);
    volume->voxels = read_any(*io, count, result);
  } catch (const itk::ExceptionObject& error) {
    std::string why = error.GetDescription();
    std::ranges::replace(why, '\n', ' ');
    throw WorkError(request.name, "cannot be read as NRRD: " + why, "is the file complete?");
  }
  result.volume = volume;
  return result;
}

}  // namespace

Format nrrd_format() { return {recognises, read}; }

}  // namespace isolux
