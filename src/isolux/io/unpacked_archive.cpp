#include "isolux/io/unpacked_archive.h"

#include <archive.h>
#include <archive_entry.h>

#include <fstream>
#include <memory>
#include <vector>

#include "isolux/base/error.h"
#include "isolux/io/read_fenced.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

WorkError damaged(const std::string& path, archive* packed) {
  const char* why = archive_error_string(packed);
  return {path, std::string("cannot be unpacked: ") + (why ? why : "it is damaged"),
          "is the file complete?"};
}

}  // namespace

UnpackedArchive::UnpackedArchive(const std::string& path)
    : folder_(temporary_folder("unpacked", path)) {
  const ReadNext next = read_fenced(path, 0, [&](FenceOutput& output) { unpack(path, output); });
  // Signs of life, one for each piece, until there are no more; then the number of files.
  for (bool goes_on = true; goes_on;) next(reinterpret_cast<char*>(&goes_on), sizeof goes_on);
  next(reinterpret_cast<char*>(&file_count_), sizeof file_count_);
}

void UnpackedArchive::unpack(const std::string& path, FenceOutput& output) {
  constexpr int kMostFiles = 100'000;
  constexpr double kSmall = 64e6, kUsualRatio = 200;  // scans seldom shrink to a tenth
  const std::unique_ptr<archive, decltype(&archive_read_free)> packed(archive_read_new(),
                                                                      archive_read_free);
  archive_read_support_format_zip(packed.get());
  archive_read_support_format_tar(packed.get());
  if (archive_read_open_filename(packed.get(), path.c_str(), 1 << 16) != ARCHIVE_OK) {
    throw damaged(path, packed.get());
  }
  const auto packed_bytes = static_cast<double>(fs::file_size(path));
  double unpacked_bytes = 0;
  std::vector<char> piece(1 << 18);
  archive_entry* entry = nullptr;
  while (true) {
    const int status = archive_read_next_header(packed.get(), &entry);
    if (status == ARCHIVE_EOF) break;
    if (status != ARCHIVE_OK && status != ARCHIVE_WARN) throw damaged(path, packed.get());
    if (archive_entry_filetype(entry) != AE_IFREG) continue;
    if (++file_count_ > kMostFiles) {
      throw WorkError(path, "holds more than 100000 files", "unpack the ones that are wanted");
    }
    // The bare name, so that slices keep their natural order and headers find their data; no path,
    // so that nothing can step out of the folder.
    const char* entry_name = archive_entry_pathname(entry);
    fs::path file_name = fs::path(entry_name ? entry_name : "").filename();
    if (file_name.empty() || file_name == "." || file_name == "..") file_name = "unnamed";
    if (fs::exists(folder() / file_name)) {
      file_name = std::to_string(file_count_) + "-" + file_name.string();
    }
    std::ofstream file(folder() / file_name, std::ios::binary);
    while (true) {
      const la_ssize_t got = archive_read_data(packed.get(), piece.data(), piece.size());
      if (got < 0) throw damaged(path, packed.get());
      if (got == 0) break;
      unpacked_bytes += static_cast<double>(got);
      if (unpacked_bytes > kSmall + kUsualRatio * packed_bytes) {
        throw WorkError(path, "unpacks to more than 200 times its size", "unpack it by hand");
      }
      file.write(piece.data(), got);
      const bool goes_on = true;
      output.send(&goes_on, sizeof goes_on);
    }
    file.close();
    if (!file) throw WorkError(path, "cannot be unpacked: no room", "set TMPDIR to another folder");
  }
  const bool goes_on = false;
  output.send(&goes_on, sizeof goes_on);
  output.send(&file_count_, sizeof file_count_);
}

}  // namespace isolux
