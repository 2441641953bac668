#include "isolux/io/unpacked_archive.h"

#include <archive.h>
#include <archive_entry.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "isolux/base/error.h"
#include "isolux/io/reader.h"
#include "isolux/io/write_volume.h"
#include "isolux/volume/phantom.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

class Zip : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("isolux-zip-test-" + std::to_string(::getpid()));
    fs::create_directory(folder_);
    path_ = (folder_ / "a.zip").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write_zip(const std::vector<std::pair<std::string, std::string>>& files,
                 bool as_tar = false) const {
    archive* zip = archive_write_new();
    as_tar ? archive_write_set_format_ustar(zip) : archive_write_set_format_zip(zip);
    archive_write_open_filename(zip, path_.c_str());
    for (const auto& [name, bytes] : files) {
      archive_entry* entry = archive_entry_new();
      archive_entry_set_pathname(entry, name.c_str());
      archive_entry_set_size(entry, static_cast<la_int64_t>(bytes.size()));
      archive_entry_set_filetype(entry, AE_IFREG);
      archive_entry_set_perm(entry, 0644);
      archive_write_header(zip, entry);
      archive_write_data(zip, bytes.data(), bytes.size());
      archive_entry_free(entry);
    }
    archive_write_close(zip);
    archive_write_free(zip);
  }

  fs::path folder_;
  std::string path_;
};

TEST_F(Zip, files_come_out_under_their_bare_names_and_go_again) {
  write_zip({{"../../escape", "one"}, {"/etc/absolute", "two"}, {"a/escape", "three"}});
  fs::path unpacked;
  {
    const UnpackedArchive zip(path_);
    unpacked = zip.folder();
    EXPECT_EQ(zip.file_count(), 3);
    EXPECT_EQ(std::distance(fs::directory_iterator(unpacked), {}), 3);
    EXPECT_EQ(fs::file_size(unpacked / "3-escape"), 5u);
  }
  EXPECT_FALSE(fs::exists(unpacked));
  EXPECT_FALSE(fs::exists(folder_.parent_path() / "escape"));
}

TEST_F(Zip, a_cut_archive_is_refused_and_leaves_no_folder) {
  write_zip({{"a", std::string(100'000, 'x') + "y"}});
  const fs::path place = folder_ / "temporary";  // where no other program leaves anything
  fs::create_directory(place);
  ::setenv("TMPDIR", place.c_str(), 1);
  fs::resize_file(path_, 60);
  EXPECT_THROW(UnpackedArchive{path_}, WorkError);
  EXPECT_TRUE(fs::is_empty(place));
  ::unsetenv("TMPDIR");
}

TEST_F(Zip, a_volume_in_a_zip_is_read) {
  const std::string nrrd = (folder_ / "v.nrrd").string();
  write_volume(nrrd, sphere_phantom(5));
  std::ifstream file(nrrd, std::ios::binary);
  write_zip({{"readme", "words"}, {"v", {std::istreambuf_iterator<char>(file), {}}}});
  const ReadResult result = read_input({path_, {}});
  EXPECT_EQ(result.volume->dims, (std::array{5, 5, 5}));
  EXPECT_EQ(result.files, std::vector<std::string>{path_});
}

TEST_F(Zip, a_header_finds_its_voxels_in_a_tar) {
  std::string voxels(27, '\0');
  voxels[13] = 1;
  write_zip({{"a/v.mhd",
              "ObjectType = Image\nNDims = 3\nDimSize = 3 3 3\nElementType = MET_UCHAR\n"
              "ElementDataFile = v.raw\n"},
             {"a/v.raw", voxels}},
            true);
  EXPECT_EQ(read_input({path_, {}}).volume->dims, (std::array{3, 3, 3}));
}

TEST_F(Zip, one_without_a_volume_is_refused) {
  write_zip({{"readme", "words"}});
  EXPECT_THROW(read_input({path_, {}}), WorkError);
}

}  // namespace
}  // namespace isolux
