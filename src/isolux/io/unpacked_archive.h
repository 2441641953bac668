#pragma once

#include <filesystem>
#include <string>

#include "isolux/base/fence.h"
#include "isolux/base/temporary_path.h"

namespace isolux {

/// The files of a zip or tar archive, unpacked by libarchive inside a fence into a new private
/// folder, which goes when this does. Of their names only the last part is kept, so that none can
/// step out of the folder; links and devices are left out.
class UnpackedArchive {
 public:
  /// @throws WorkError  where the archive is damaged, is encrypted, unpacks to more than 64 MB and
  /// 200 times its size, or has more than a hundred thousand files.
  explicit UnpackedArchive(const std::string& path);

  std::filesystem::path folder() const { return folder_.path(); }
  int file_count() const { return file_count_; }

 private:
  void unpack(const std::string& path, FenceOutput& output);

  TemporaryPath folder_;
  int file_count_ = 0;
};

}  // namespace isolux
