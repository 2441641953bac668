#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "isolux/base/affine.h"
#include "isolux/base/error.h"
#include "isolux/base/fence.h"
#include "isolux/base/memory.h"
#include "isolux/base/number_text.h"
#include "isolux/image/display.h"
#include "isolux/image/jpeg.h"
#include "isolux/image/png.h"
#include "isolux/io/data_file.h"
#include "isolux/io/format.h"
#include "isolux/io/mesh_header.h"
#include "isolux/io/mesh_import.h"
#include "isolux/mesh/weld.h"

// Mesh files are read by assimp in a child process (mesh_import.h). What it sends home is checked
// here, and carried to LPS millimetres.

namespace isolux {
namespace {

namespace fs = std::filesystem;

std::string first_bytes_of(const std::string& path) {
  std::string bytes(64 << 10, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

double size_of(const std::string& path) {
  std::error_code error;
  const auto bytes = fs::file_size(path, error);
  return error ? 0 : static_cast<double>(bytes);
}

// From the file's space to LPS millimetres.
Affine world_from_file(const std::string& kind, MeshSpace space) {
  // Metres with +y up and +z to the front.
  if (kind == "gltf" || kind == "glb") return {{{{1000, 0, 0}, {0, 0, 1000}, {0, -1000, 0}}}, {}};
  return {diagonal(space == MeshSpace::kRas ? Vec3{-1, -1, 1} : Vec3{1, 1, 1}), {}};
}

// Takes in what the child sends.
class MeshReceiver {
 public:
  MeshReceiver(const MeshFile& file, double bytes, Fence& input, ReadResult& result)
      : file_(file), bytes_(bytes), input_(input), result_(result) {}

  Mesh receive(const Affine& to_world) {
    if (const std::string why = input_.receive_text(); !why.empty()) refuse(why);
    for (const std::string& name : receive_names()) add_file(name);
    for (const std::string& name : receive_names()) {
      note("its file '" + name + "' is not there, or not beside or below it: left out");
    }
    const std::uint64_t materials = receive_count();
    for (std::uint64_t n = 0; n < materials; ++n) receive_material();
    const std::uint64_t parts = receive_count();
    for (std::uint64_t n = 0; n < parts; ++n) receive_part(to_world);
    tell_what_was_left_out();
    if (mesh_.triangles.empty()) refuse("holds no triangles");
    drop_unused_materials();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& why) {
    throw WorkError(file_.path, why, "is it complete, and a mesh?");
  }
  void note(const std::string& text) { result_.notes.push_back(text); }
  void add_file(const std::string& path) {
    if (std::ranges::find(result_.files, path) == result_.files.end())
      result_.files.push_back(path);
  }

  template <typename T>
  T receive_one() {
    T value;
    input_.receive(&value, sizeof value);
    return value;
  }
  template <typename T>
  std::vector<T> receive_many(std::uint64_t count) {
    std::vector<T> values(count);
    input_.receive(values.data(), count * sizeof(T));
    return values;
  }
  // Of materials, parts and names: each sends more than nothing, so a hostile count comes to an
  // end, but not soon.
  std::uint64_t receive_count() {
    const auto count = receive_one<std::uint64_t>();
    if (static_cast<double>(count) > bytes_) refuse("holds more parts than bytes");
    return count;
  }
  std::vector<std::string> receive_names() {
    std::vector<std::string> names(receive_count());
    for (std::string& name : names) name = input_.receive_text();
    return names;
  }

  // --- Materials ---

  void receive_material() {
    const auto from = receive_one<ImportedMaterial>();
    MeshMaterial to;
    to.name = input_.receive_text();
    const std::string texture = input_.receive_text();
    if (from.is_given) {
      to.material.ka = coefficient(from.ka, to.name);
      to.material.kd = coefficient(from.kd, to.name);
      to.material.ks = coefficient(from.ks, to.name);
      if (from.shininess > 0 && std::isfinite(from.shininess)) {
        to.material.shininess = from.shininess;
      }
    }
    if (from.is_texture_embedded) {
      to.base_color = picture_of(texture, "its own texture");
    } else if (!texture.empty()) {
      to.base_color = picture_in(texture);
    }
    mesh_.materials.push_back(to);
  }

  Rgb coefficient(const double* from, const std::string& name) {
    const auto clamped = [](double v) { return v >= 0 ? std::min(v, 1.0) : 0.0; };
    const Rgb to{clamped(from[0]), clamped(from[1]), clamped(from[2])};
    if (to != Rgb{from[0], from[1], from[2]}) {
      note("the material '" + name + "' has coefficients outside 0 to 1: they were clamped");
    }
    return to;
  }

  std::shared_ptr<const Picture> picture_in(std::string named) {
    std::ranges::replace(named, '\\', '/');  // as some programs on Windows write
    try {
      const std::string path = data_file_beside(file_.path, named);
      std::ifstream file(path, std::ios::binary);
      const std::string bytes(std::istreambuf_iterator<char>(file), {});
      add_file(path);
      return picture_of(bytes, "its texture " + path);
    } catch (const WorkError& error) {
      note(std::string(error.what()) + ": drawn without this texture");
      return nullptr;
    }
  }

  std::shared_ptr<const Picture> picture_of(const std::string& bytes, const std::string& name) {
    try {
      if (bytes.starts_with("\x89PNG")) {
        return std::make_shared<const Picture>(decode_png(bytes, name).picture);
      }
      if (bytes.starts_with("\xff\xd8")) {
        return std::make_shared<const Picture>(decode_jpeg(bytes, name));
      }
      note(name + " is neither PNG nor JPEG: drawn without it");
    } catch (const WorkError& error) {
      note(std::string(error.what()) + ": drawn without this texture");
    }
    return nullptr;
  }

  // --- Parts ---

  void check_size(const ImportedPart& part) {
    constexpr double kBytesOfVertex = sizeof(Vec3f) * 3 + sizeof(TexturePoint);
    total_ += static_cast<double>(part.vertices) * (kBytesOfVertex + sizeof(Vec3)) +
              static_cast<double>(part.triangles) * 2 * sizeof(Mesh::Triangle);
    constexpr double kMostTimes = 400, kAlwaysGood = 64e6;
    if (total_ > kMostTimes * bytes_ && total_ > kAlwaysGood && !memory_limit_is_set()) {
      refuse("unpacks to over " + to_text(kMostTimes) + " times its size");
    }
    check_memory(total_, file_.path);
    const double vertices =
        static_cast<double>(mesh_.positions.size()) + static_cast<double>(part.vertices);
    const double triangles =
        static_cast<double>(mesh_.triangles.size()) + static_cast<double>(part.triangles);
    if (vertices > 0xfffffffe || triangles > 0xfffffffe) refuse("holds over 4294967294 vertices");
  }

  void receive_part(const Affine& to_world) {
    const auto part = receive_one<ImportedPart>();
    check_size(part);
    if (part.material >= mesh_.materials.size()) refuse("names a material that it has not");
    other_faces_ += part.other_faces;
    const auto first_vertex = static_cast<std::uint32_t>(mesh_.positions.size());
    append_positions(receive_many<Vec3>(part.vertices), to_world);
    append(mesh_.normals, part, part.has_normals, [&](Vec3 n) {
      const Vec3 normal = to_world.linear * n;  // a rotation and a scale: as good as M^-T here
      return is_finite(normal) && normal != Vec3{} ? as_float(normalize(normal)) : Vec3f{};
    });
    append(mesh_.texture_points, part, part.has_texture_points, [](Vec3 p) {
      return is_finite(p) ? TexturePoint{static_cast<float>(p.x), static_cast<float>(p.y)}
                          : TexturePoint{};
    });
    append_colors(part);
    append_triangles(receive_many<Mesh::Triangle>(part.triangles), first_vertex, part);
  }

  void append_positions(const std::vector<Vec3>& positions, const Affine& to_world) {
    for (const Vec3& position : positions) {
      mesh_.positions.push_back(as_float(to_world.point(position)));
    }
  }

  // Vertices before the first part that has this attribute, and of parts without it, get a T{}.
  template <typename T>
  void append(std::vector<T>& to, const ImportedPart& part, bool is_there, const auto& value_of,
              T missing = {}) {
    if (!is_there && to.empty()) return;
    to.resize(mesh_.positions.size() - part.vertices, missing);
    if (is_there) {
      for (const Vec3& value : receive_many<Vec3>(part.vertices)) to.push_back(value_of(value));
    }
    to.resize(mesh_.positions.size(), missing);
  }

  void append_colors(const ImportedPart& part) {
    const bool is_linear = file_.ending == "gltf" || file_.ending == "glb";
    const auto channel = [&](double v) {
      const double clamped = v >= 0 ? std::min(v, 1.0) : 0;
      return is_linear ? clamped : linear_from_srgb(clamped);
    };
    append(
        mesh_.colors, part, part.has_colors,
        [&](Vec3 c) {
          return as_float({channel(c.x), channel(c.y), channel(c.z)});
        },
        Vec3f{1, 1, 1});
  }

  void append_triangles(const std::vector<Mesh::Triangle>& triangles, std::uint32_t first_vertex,
                        const ImportedPart& part) {
    const std::size_t first = mesh_.triangles.size();
    for (Mesh::Triangle triangle : triangles) {
      const auto is_outside = [&](std::uint32_t v) { return v >= part.vertices; };
      if (std::ranges::any_of(triangle, is_outside)) {
        ++out_of_range_;
        continue;
      }
      for (std::uint32_t& vertex : triangle) vertex += first_vertex;
      const auto is_bad = [&](std::uint32_t v) {
        return !is_finite(as_double(mesh_.positions[v]));
      };
      if (std::ranges::any_of(triangle, is_bad)) {
        ++not_finite_;
        continue;
      }
      const auto [a, b, c] = corners(mesh_, triangle);
      if (a == b || b == c || c == a) {
        ++collapsed_;
        continue;
      }
      mesh_.triangles.push_back(triangle);
    }
    if (mesh_.triangles.size() == first) return;
    mesh_.parts.push_back({static_cast<std::uint32_t>(first),
                           static_cast<std::uint32_t>(mesh_.triangles.size() - first),
                           part.material});
  }

  void drop_unused_materials() {
    std::vector<MeshMaterial> used;
    std::map<std::uint32_t, std::uint32_t> place;
    for (MeshPart& part : mesh_.parts) {
      const auto [at, is_new] =
          place.try_emplace(part.material, static_cast<std::uint32_t>(used.size()));
      if (is_new) used.push_back(mesh_.materials[part.material]);
      part.material = at->second;
    }
    mesh_.materials = std::move(used);
  }

  void tell_what_was_left_out() {
    const auto tell = [&](std::uint64_t count, const char* what) {
      if (count > 0) note("left out " + std::to_string(count) + what);
    };
    tell(other_faces_, " points and lines");
    tell(out_of_range_, " triangles with a vertex that is not there");
    tell(not_finite_, " triangles with a corner that is no number");
    tell(collapsed_, " triangles with two corners in one place");
  }

  const MeshFile& file_;
  double bytes_;
  Fence& input_;
  ReadResult& result_;
  Mesh mesh_;
  double total_ = 0;
  std::uint64_t other_faces_ = 0, out_of_range_ = 0, not_finite_ = 0, collapsed_ = 0;
};

std::string kind_of(const ReadRequest& request, std::string_view first_bytes) {
  return mesh_kind(request.name, first_bytes, size_of(request.name));
}

bool recognises(const ReadRequest& request, std::string_view first_bytes) {
  return !kind_of(request, first_bytes).empty();
}

const char* format_name(const std::string& kind) {
  if (kind == "stl") return "STL";
  if (kind == "ply") return "PLY";
  return kind == "obj" ? "OBJ" : "glTF";
}

OpenedInput open(const ReadRequest& request) {
  const std::string first_bytes = first_bytes_of(request.name);
  const double bytes = size_of(request.name);
  const MeshFile file{request.name, kind_of(request, first_bytes)};
  check_mesh_promise(file.path, file.ending, first_bytes, bytes);
  OpenedInput opened;
  ReadResult& result = opened.result;
  result.name = request.name;
  result.format = format_name(file.ending);
  result.files = {request.name};
  const MeshSpace space = mesh_space(file.ending, first_bytes);
  if (space == MeshSpace::kRas) result.notes.push_back("its tag says RAS: x and y were negated");
  if (result.format == "glTF") {
    result.notes.push_back("glTF is in metres with +y up: +y became superior, +z anterior");
  }
  // assimp makes about 20 bytes of one; a second for each megabyte is ten times what it takes.
  const FenceLimits limits{.seconds = 5 + bytes / 1e6, .memory = 256e6 + 40 * bytes};
  try {
    Fence fence(limits, [&](FenceOutput& output) { import_mesh(file, output); });
    Mesh mesh =
        MeshReceiver(file, bytes, fence, result).receive(world_from_file(file.ending, space));
    weld(mesh);
    result.mesh = std::make_shared<const Mesh>(std::move(mesh));
  } catch (const FenceBroken& broken) {
    throw WorkError(file.path, std::string("reading it ") + broken.what(),
                    "the file is damaged, or not what it seems");
  }
  return opened;
}

}  // namespace

Format mesh_format() { return {recognises, open}; }

}  // namespace isolux
