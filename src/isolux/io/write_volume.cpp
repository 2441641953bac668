#include "isolux/io/write_volume.h"

#include <nifti/nifti1_io.h>
#include <zlib.h>

#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "isolux/base/error.h"
#include "isolux/base/number_text.h"
#include "isolux/base/output_file.h"
#include "isolux/io/nifti_header.h"

// The three containers are a short header before the bare voxels, so they are made here, in memory:
// that way the file takes its place whole or not at all. Compression is zlib's.

namespace isolux {
namespace {

std::string_view bytes_of_voxels(const Volume& volume) {
  return std::visit(
      [](const auto& voxels) {
        return std::string_view(reinterpret_cast<const char*>(voxels.data()),
                                voxels.size() * sizeof(voxels[0]));
      },
      volume.voxels);
}

// zlib's windowBits + 16 asks for a gzip header, windowBits alone for zlib's own.
std::string deflated(std::string_view bytes, bool gzip) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, gzip ? 15 + 16 : 15, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw WorkError("zlib", "cannot compress", "is there enough memory?");
  }
  std::string out;
  std::string piece(1 << 20, '\0');
  int status = Z_OK;
  while (status != Z_STREAM_END) {
    if (stream.avail_in == 0 && !bytes.empty()) {
      const std::size_t take = std::min<std::size_t>(bytes.size(), 1 << 30);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
      stream.avail_in = static_cast<uInt>(take);
      bytes.remove_prefix(take);
    }
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = static_cast<uInt>(piece.size());
    status = deflate(&stream, bytes.empty() ? Z_FINISH : Z_NO_FLUSH);
    out.append(piece, 0, piece.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  return out;
}

std::string listed(Vec3 v, const char* separator) {
  return to_text(v.x) + separator + to_text(v.y) + separator + to_text(v.z);
}

std::string dims_text(const Volume& volume) {
  return std::to_string(volume.dims[0]) + " " + std::to_string(volume.dims[1]) + " " +
         std::to_string(volume.dims[2]);
}

std::string as_nrrd(const Volume& volume) {
  constexpr const char* kTypes[] = {"uint8", "int16", "uint16", "float"};
  const Mat3& m = volume.world_from_index.linear;
  std::string header = "NRRD0004\n# written by isolux\ntype: ";
  header += kTypes[volume.voxels.index()];
  header += "\ndimension: 3\nspace: left-posterior-superior\nsizes: " + dims_text(volume) +
            "\nspace directions: (" + listed(m.column[0], ",") + ") (" + listed(m.column[1], ",") +
            ") (" + listed(m.column[2], ",") +
            ")\nkinds: domain domain domain\nendian: little\nencoding: gzip\nspace origin: (" +
            listed(volume.world_from_index.offset, ",") + ")\n";
  if (!volume.modality.empty()) header += "modality:=" + volume.modality + "\n";
  if (!volume.units.empty()) header += "units:=" + volume.units + "\n";
  return header + "\n" + deflated(bytes_of_voxels(volume), true);
}

std::string as_metaimage(const Volume& volume) {
  constexpr const char* kTypes[] = {"MET_UCHAR", "MET_SHORT", "MET_USHORT", "MET_FLOAT"};
  const Mat3 unit = direction(volume);
  const std::string data = deflated(bytes_of_voxels(volume), false);
  std::string header =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "CompressedData = True\nCompressedDataSize = " +
      std::to_string(data.size()) + "\nTransformMatrix = " + listed(unit.column[0], " ") + " " +
      listed(unit.column[1], " ") + " " + listed(unit.column[2], " ") +
      (volume.modality == "CT" ? "\nModality = MET_MOD_CT" : "") +
      "\nOffset = " + listed(volume.world_from_index.offset, " ") +
      "\nCenterOfRotation = 0 0 0\nElementSpacing = " + listed(spacing_mm(volume), " ") +
      "\nDimSize = " + dims_text(volume) + "\nElementType = ";
  header += kTypes[volume.voxels.index()];
  return header + "\nElementDataFile = LOCAL\n" + data;
}

// What stands behind the header of a NIfTI file that has a comment: the mark that it has, and the
// extension, whose length is a multiple of 16.
std::string comment(const std::string& text) {
  const std::size_t length = (2 * sizeof(std::int32_t) + text.size() + 16) / 16 * 16;
  const std::int32_t head[] = {static_cast<std::int32_t>(length), NIFTI_ECODE_COMMENT};
  std::string bytes("\1\0\0\0", 4);
  bytes.append(reinterpret_cast<const char*>(head), sizeof head).append(text);
  bytes.resize(4 + length);
  return bytes;
}

std::string as_nifti(const Volume& volume) {
  constexpr short kTypes[] = {DT_UINT8, DT_INT16, DT_UINT16, DT_FLOAT32};
  constexpr short kBits[] = {8, 16, 16, 32};
  nifti_1_header header{};
  header.sizeof_hdr = sizeof header;
  header.dim[0] = 3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (volume.dims[axis] > 32767) {
      throw WorkError("NIfTI-1", "holds at most 32767 voxels along an axis", "write .nrrd instead");
    }
    header.dim[axis + 1] = static_cast<short>(volume.dims[axis]);
    header.pixdim[axis + 1] = static_cast<float>(spacing_mm(volume)[static_cast<int>(axis)]);
  }
  for (int axis = 4; axis < 8; ++axis) header.dim[axis] = 1;
  header.pixdim[0] = 1;
  header.datatype = kTypes[volume.voxels.index()];
  header.bitpix = kBits[volume.voxels.index()];
  header.scl_slope = 1;
  header.xyzt_units = NIFTI_UNITS_MM;
  header.sform_code = NIFTI_XFORM_SCANNER_ANAT;
  const Affine& placed = volume.world_from_index;
  float* rows[] = {header.srow_x, header.srow_y, header.srow_z};
  std::string full(kFullSform);
  bool rounds = false;
  for (int row = 0; row < 3; ++row) {
    const double to_ras = row < 2 ? -1 : 1;  // LPS to RAS
    for (int column = 0; column < 4; ++column) {
      const double number =
          to_ras * (column < 3 ? placed.linear.at(row, column) : placed.offset[row]);
      rows[row][column] = static_cast<float>(number);
      rounds = rounds || static_cast<double>(rows[row][column]) != number;
      full += to_text(number) + " ";
    }
  }
  std::memcpy(header.magic, "n+1", 4);
  const std::string extension = rounds ? comment(full) : std::string(4, '\0');
  header.vox_offset = static_cast<float>(sizeof header + extension.size());
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof header);
  return bytes.append(extension).append(bytes_of_voxels(volume));
}

std::string as_gzipped_nifti(const Volume& volume) { return deflated(as_nifti(volume), true); }

using Encoder = std::string (*)(const Volume&);

Encoder encoder_for(const std::string& path) {
  constexpr std::pair<const char*, Encoder> kEncoders[] = {{".nrrd", as_nrrd},
                                                           {".mha", as_metaimage},
                                                           {".nii", as_nifti},
                                                           {".nii.gz", as_gzipped_nifti}};
  for (const auto& [ending, encoder] : kEncoders) {
    if (path.ends_with(ending)) return encoder;
  }
  throw UsageError(path, "is of no format that is written here",
                   "name the output OUT.nrrd, OUT.nii.gz, OUT.nii or OUT.mha");
}

}  // namespace

void check_volume_name(const std::string& path) { encoder_for(path); }

void write_volume(const std::string& path, const Volume& volume) {
  write_whole_file(path, encoder_for(path)(volume));
}

}  // namespace isolux
