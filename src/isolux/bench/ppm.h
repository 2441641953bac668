#pragma once

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

// Pictures between processes: binary PPM, 8-bit RGB, row 0 at the top. Standard library alone, so
// that peers can use it without linking isolux.

namespace isolux {

struct Ppm {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

inline void write_ppm(const std::string& path, int width, int height,
                      const std::vector<std::uint8_t>& rgb) {
  std::ofstream file(path, std::ios::binary);
  file << "P6\n" << width << " " << height << "\n255\n";
  file.write(reinterpret_cast<const char*>(rgb.data()), static_cast<std::streamsize>(rgb.size()));
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

/// Reads what write_ppm wrote.
inline Ppm read_ppm(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic;
  int greatest = 0;
  Ppm picture;
  file >> magic >> picture.width >> picture.height >> greatest;
  file.get();
  if (!file || magic != "P6") throw std::runtime_error("no PPM picture in " + path);
  picture.rgb.resize(3 * static_cast<std::size_t>(picture.width) *
                     static_cast<std::size_t>(picture.height));
  file.read(reinterpret_cast<char*>(picture.rgb.data()),
            static_cast<std::streamsize>(picture.rgb.size()));
  if (!file) throw std::runtime_error("too short a picture in " + path);
  return picture;
}

}  // namespace isolux
