#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace isolux {

/// A file of the shared test data ("nifti/FLAIR.nii.gz"): in the folder that the environment
/// variable SHARED names, else in ../shared beside the source tree. Empty where there is none.
inline std::string shared_data(const std::string& name) {
  const char* folder = std::getenv("SHARED");
  const std::filesystem::path path =
      std::filesystem::path(folder ? folder : ISOLUX_SHARED) / "data" / name;
  return std::filesystem::exists(path) ? path.string() : std::string();
}

}  // namespace isolux

/// Skips the test where a file of the shared test data is not on this machine.
#define ISOLUX_NEEDS(name) \
  if (isolux::shared_data(name).empty()) GTEST_SKIP() << "the shared test data have no " << (name)
