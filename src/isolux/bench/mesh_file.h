#pragma once

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

// Standard library alone, so that peers can use it without linking isolux.

namespace isolux {

/// A surface as it goes from one peer to the other.
struct PeerMesh {
  std::vector<float> positions;          ///< x, y, z of each vertex, mm
  std::vector<float> normals;            ///< x, y, z of each vertex, unit
  std::vector<std::uint32_t> triangles;  ///< three vertices each
};

// The file: two 64-bit counts, of vertices and triangles, then the three lists.

inline void write_peer_mesh(const std::string& path, const PeerMesh& mesh) {
  std::ofstream file(path, std::ios::binary);
  const auto put = [&](const auto* values, std::size_t count) {
    file.write(reinterpret_cast<const char*>(values),
               static_cast<std::streamsize>(count * sizeof *values));
  };
  const std::uint64_t counts[] = {mesh.positions.size() / 3, mesh.triangles.size() / 3};
  put(counts, 2);
  put(mesh.positions.data(), mesh.positions.size());
  put(mesh.normals.data(), mesh.normals.size());
  put(mesh.triangles.data(), mesh.triangles.size());
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

inline PeerMesh read_peer_mesh(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const auto get = [&](auto* values, std::size_t count) {
    file.read(reinterpret_cast<char*>(values),
              static_cast<std::streamsize>(count * sizeof *values));
    if (!file) throw std::runtime_error("cannot read " + path + ", or it is too short");
  };
  std::uint64_t counts[2];
  get(counts, 2);
  PeerMesh mesh;
  mesh.positions.resize(3 * counts[0]);
  mesh.normals.resize(3 * counts[0]);
  mesh.triangles.resize(3 * counts[1]);
  get(mesh.positions.data(), mesh.positions.size());
  get(mesh.normals.data(), mesh.normals.size());
  get(mesh.triangles.data(), mesh.triangles.size());
  return mesh;
}

}  // namespace isolux
