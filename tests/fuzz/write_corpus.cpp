// write_corpus FOLDER: the seeds of every format, in a folder each, for libFuzzer.

#include <filesystem>
#include <fstream>

#include "fuzz/seeds.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  for (const char* format :
       {"nrrd", "nifti", "metaimage", "tiff", "inv3", "dicom", "vti", "raw", "scene"}) {
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / format;
    std::filesystem::create_directories(folder);
    int number = 0;
    for (const std::string& seed : isolux::fuzz::seeds_of(format)) {
      std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary) << seed;
    }
  }
  return 0;
}
