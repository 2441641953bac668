#include "fuzz/seeds.h"

#include <archive.h>
#include <archive_entry.h>
#include <tiffio.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "isolux/io/write_mesh.h"
#include "isolux/io/write_volume.h"
#include "isolux/mesh/extract_isosurface.h"
#include "isolux/volume/phantom.h"
#include "isolux/volume/regrid.h"

namespace isolux::fuzz {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// A file written by `write(path)`, as bytes.
template <typename Write>
std::string bytes_of_file(const std::string& ending, const Write& write) {
  const fs::path path =
      fs::temp_directory_path() / ("isolux-seed-" + std::to_string(::getpid()) + ending);
  write(path.string());
  const std::string bytes = contents(path);
  fs::remove(path);
  return bytes;
}

std::string written(const Volume& volume, const std::string& ending) {
  return bytes_of_file(ending, [&](const std::string& path) { write_volume(path, volume); });
}

std::string written(const Mesh& mesh, const std::string& ending) {
  return bytes_of_file(ending,
                       [&](const std::string& path) { write_mesh(path, mesh, MeshSpace::kLps); });
}

const std::string kStlText =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nendsolid a\n";
const std::string kPlyText =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n"
    "4 0 1 2 3\n";

std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int n = 0; n < bytes; ++n) text += static_cast<char>(value >> (8 * n));
  return text;
}

std::string tiff(const char* mode, bool tiled) {
  return bytes_of_file(".tif", [&](const std::string& path) {
    const std::unique_ptr<TIFF, decltype(&TIFFClose)> file(TIFFOpen(path.c_str(), mode), TIFFClose);
    for (int page = 0; page < 3; ++page) {
      TIFFSetField(file.get(), TIFFTAG_IMAGEWIDTH, 16);
      TIFFSetField(file.get(), TIFFTAG_IMAGELENGTH, 16);
      TIFFSetField(file.get(), TIFFTAG_BITSPERSAMPLE, 8);
      TIFFSetField(file.get(), TIFFTAG_SAMPLESPERPIXEL, 1);
      TIFFSetField(file.get(), TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
      TIFFSetField(file.get(), TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
      std::vector<unsigned char> pixels(256, static_cast<unsigned char>(page * 50));
      if (tiled) {
        TIFFSetField(file.get(), TIFFTAG_TILEWIDTH, 16);
        TIFFSetField(file.get(), TIFFTAG_TILELENGTH, 16);
        TIFFWriteTile(file.get(), pixels.data(), 0, 0, 0, 0);
      } else {
        for (std::uint32_t y = 0; y < 16; ++y) {
          TIFFWriteScanline(file.get(), pixels.data() + 16 * y, y, 0);
        }
      }
      TIFFWriteDirectory(file.get());
    }
  });
}

void add_entry(archive* tar, const std::string& name, const std::string& bytes) {
  archive_entry* entry = archive_entry_new();
  archive_entry_set_pathname(entry, name.c_str());
  archive_entry_set_size(entry, static_cast<la_int64_t>(bytes.size()));
  archive_entry_set_filetype(entry, AE_IFREG);
  archive_entry_set_perm(entry, 0644);
  archive_write_header(tar, entry);
  archive_write_data(tar, bytes.data(), bytes.size());
  archive_entry_free(entry);
}

std::string inv3() {
  return bytes_of_file(".inv3", [](const std::string& path) {
    archive* tar = archive_write_new();
    archive_write_add_filter_gzip(tar);
    archive_write_set_format_ustar(tar);
    archive_write_open_filename(tar, path.c_str());
    add_entry(tar, "p/main.plist",
              "<plist><dict><key>matrix</key><dict><key>dtype</key><string>int16</string>"
              "<key>filename</key><string>matrix.dat</string><key>shape</key><array>"
              "<integer>4</integer><integer>4</integer><integer>4</integer></array></dict>"
              "<key>modality</key><string>CT</string><key>orientation</key><integer>1</integer>"
              "<key>spacing</key><array><real>1</real><real>1</real><real>2</real></array>"
              "</dict></plist>");
    add_entry(tar, "p/matrix.dat", std::string(128, '\3'));
    archive_write_close(tar);
    archive_write_free(tar);
  });
}

// One element of a DICOM data set, explicit VR little endian.
std::string element(unsigned group, unsigned number, const std::string& vr, std::string value) {
  if (value.size() % 2) value += vr == "UI" ? '\0' : ' ';
  const bool is_long = vr == "OW" || vr == "OB";
  return little_endian(group, 2) + little_endian(number, 2) + vr +
         (is_long ? little_endian(0, 2) + little_endian(value.size(), 4)
                  : little_endian(value.size(), 2)) +
         value;
}

std::string dicom(const std::string& slope) {
  const std::string syntax = element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  const auto number = [](std::uint64_t value) { return little_endian(value, 2); };
  return std::string(128, '\0') + "DICM" + element(2, 0, "UL", little_endian(syntax.size(), 4)) +
         syntax + element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2") +
         element(8, 0x18, "UI", "1.2.3.4") + element(8, 0x60, "CS", "CT") +
         element(0x20, 0xd, "UI", "1.2.3") + element(0x20, 0xe, "UI", "1.2.3.1") +
         element(0x20, 0x32, "DS", "0\\0\\0") + element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") +
         element(0x28, 2, "US", number(1)) + element(0x28, 4, "CS", "MONOCHROME2") +
         element(0x28, 0x10, "US", number(4)) + element(0x28, 0x11, "US", number(4)) +
         element(0x28, 0x30, "DS", "1\\1") + element(0x28, 0x100, "US", number(16)) +
         element(0x28, 0x101, "US", number(16)) + element(0x28, 0x102, "US", number(15)) +
         element(0x28, 0x103, "US", number(1)) + element(0x28, 0x1052, "DS", "-1024") +
         element(0x28, 0x1053, "DS", slope) + element(0x7fe0, 0x10, "OW", std::string(32, '\7'));
}

const std::string kVtiGrid =
    "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" header_type=\"UInt32\">"
    "<ImageData WholeExtent=\"0 1 0 1 0 1\" Origin=\"1 2 3\" Spacing=\"1 1 2\">"
    "<Piece Extent=\"0 1 0 1 0 1\"><PointData Scalars=\"a\">";

std::string vti(const std::string& encoding, const std::string& data) {
  return kVtiGrid +
         "<DataArray type=\"UInt8\" Name=\"a\" format=\"appended\" offset=\"0\"/></PointData>"
         "</Piece></ImageData><AppendedData encoding=\"" +
         encoding + "\">" + data + "</AppendedData></VTKFile>";
}

std::string vti_inline() {
  return kVtiGrid +
         "<DataArray type=\"Int32\" Name=\"a\" format=\"ascii\">1 2 3 4 -5 6 7 80000</DataArray>"
         "<DataArray type=\"UInt8\" Name=\"b\" format=\"binary\">CAAAAGFiY2RlZmdo</DataArray>"
         "</PointData></Piece></ImageData></VTKFile>";
}

}  // namespace

std::vector<std::string> seeds_of(const std::string& format) {
  const Volume volume = head_phantom(6);
  Volume oblique = sphere_phantom(5);
  oblique.world_from_index = {{{{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0.1, 3}}}, {1, 2, 3}};
  if (format == "nrrd") {
    return {
        written(volume, ".nrrd"), written(oblique, ".nrrd"),
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 2 3\nencoding: raw\n\n"
        "abcdefgh",
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 2 2 2\nkinds: RGB-color space space space\n"
        "encoding: hex\n\n" +
            std::string(48, '7')};
  }
  if (format == "nifti") {
    return {written(volume, ".nii"), written(oblique, ".nii.gz"), written(oblique, ".nii")};
  }
  if (format == "metaimage") {
    return {
        written(volume, ".mha"), written(oblique, ".mha"),
        "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nabcdefgh",
        // 2^64 voxels, which 64 bits take for none
        "NDims = 3\nDimSize = 4194304 2097152 2097152\nElementType = MET_UCHAR\n"
        "ElementDataFile = LOCAL\nabcdefgh",
        "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementNumberOfChannels = 3\n"
        "ElementDataFile = LOCAL\nabcdefghabcdefghabcdefgh"};
  }
  if (format == "tiff") return {tiff("wl", false), tiff("wb", true), tiff("w8", false)};
  if (format == "inv3") return {inv3()};
  if (format == "dicom") return {dicom("1"), dicom("0.5")};
  if (format == "stl" || format == "ply" || format == "obj" || format == "glb") {
    Mesh mesh = extract_isosurface(sphere_phantom(5), 0.4);
    const std::string plain = written(mesh, "." + format);
    mesh.colors.assign(mesh.positions.size(), {1, 0.5f, 0});
    mesh.texture_points.resize(mesh.positions.size());
    std::vector<std::string> seeds{plain, written(mesh, "." + format)};
    if (format == "stl") seeds.push_back(kStlText);
    if (format == "ply") seeds.push_back(kPlyText);
    return seeds;
  }
  if (format == "vti")
    return {vti("raw", "_" + little_endian(8, 4) + "abcdefgh"), vti("base64", "_CAAAAGFiY2RlZmdo"),
            vti_inline()};
  if (format == "raw")
    return {std::string("\1\1\1\1", 4) + std::string(16, 'a'),
            std::string("\2\0\0\6", 4) + std::string(12, 'a')};
  if (format == "scene") {
    return {R"({"isolux_scene": 1, "input": ["phantom:head"], "size": [64, 48],)"
            R"( "surface": [{"iso": 300, "ka": [0.1, 0.2, 0.3], "shininess": 10}],)"
            R"( "light": [{"kind": "point", "at": [0, 0, 57], "space": "index"}],)"
            R"( "camera": {"view": "left", "projection": "orthographic", "height": 20}})"};
  }
  throw std::invalid_argument("no seeds for " + format);
}

}  // namespace isolux::fuzz
