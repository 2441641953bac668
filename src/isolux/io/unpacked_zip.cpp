#include "isolux/io/unpacked_zip.h"

#include <archive.h>
#include <archive_entry.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <vector>

#include "isolux/base/error.h"
#include "isolux/base/memory.h"
#include "isolux/io/stored_voxels.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

WorkError damaged(const std::string& path, archive* zip) {
  const char* why = archive_error_string(zip);
  return {path, std::string("cannot be unpacked: ") + (why ? why : "it is damaged"),
          "is the file complete?"};
}

}  // namespace

UnpackedZip::UnpackedZip(const std::string& path) {
  std::string name = (fs::temp_directory_path() / "isolux-zip-XXXXXX").string();
  if (!::mkdtemp(name.data())) {
    throw WorkError(name, "cannot be made to unpack into", "set TMPDIR to a folder with room");
  }
  folder_ = name;
  try {
    unpack(path);
  } catch (...) {  // a constructor that throws has no destructor
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    throw;
  }
}

UnpackedZip::~UnpackedZip() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void UnpackedZip::unpack(const std::string& path) {
  constexpr int kMostFiles = 100'000;
  const std::unique_ptr<archive, decltype(&archive_read_free)> zip(archive_read_new(),
                                                                   archive_read_free);
  archive_read_support_format_zip(zip.get());
  if (archive_read_open_filename(zip.get(), path.c_str(), 1 << 16) != ARCHIVE_OK) {
    throw damaged(path, zip.get());
  }
  const auto packed_bytes = static_cast<double>(fs::file_size(path));
  double unpacked_bytes = 0;
  std::vector<char> piece(1 << 18);
  archive_entry* entry = nullptr;
  while (true) {
    const int status = archive_read_next_header(zip.get(), &entry);
    if (status == ARCHIVE_EOF) return;
    if (status != ARCHIVE_OK && status != ARCHIVE_WARN) throw damaged(path, zip.get());
    if (archive_entry_filetype(entry) != AE_IFREG) continue;
    if (++file_count_ > kMostFiles) {
      throw WorkError(path, "holds more than 100000 files", "unpack the ones that are wanted");
    }
    char file_name[32];
    std::snprintf(file_name, sizeof file_name, "%06d", file_count_);
    std::ofstream file(folder_ / file_name, std::ios::binary);
    while (true) {
      const la_ssize_t got = archive_read_data(zip.get(), piece.data(), piece.size());
      if (got < 0) throw damaged(path, zip.get());
      if (got == 0) break;
      unpacked_bytes += static_cast<double>(got);
      check_promise(path, unpacked_bytes, packed_bytes, "deflate");
      file.write(piece.data(), got);
    }
    file.close();
    if (!file) throw WorkError(path, "cannot be unpacked: no room", "set TMPDIR to another folder");
  }
}

}  // namespace isolux
