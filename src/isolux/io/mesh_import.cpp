#include "isolux/io/mesh_import.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <filesystem>
#include <vector>

#include "isolux/base/affine.h"
#include "isolux/base/error.h"
#include "isolux/io/data_file.h"

namespace isolux {
namespace {

const std::string kName = "isolux-mesh.";

// Opens the file itself, under a name whose ending tells assimp what it is, and what it names
// beside or below it; nothing else.
class MeshFiles : public Assimp::DefaultIOSystem {
 public:
  explicit MeshFiles(const MeshFile& file)
      : path_(file.path), folder_(std::filesystem::path(file.path).parent_path().string()) {
    name_ = (std::filesystem::path(folder_) / (kName + file.ending)).string();
  }

  const std::string& name() const { return name_; }

  bool Exists(const char* named) const override { return named == name_ || !beside(named).empty(); }
  Assimp::IOStream* Open(const char* named, const char* mode) override {
    if (named == name_) return DefaultIOSystem::Open(path_.c_str(), mode);
    const std::string path = beside(named);
    if (path.empty()) {
      add_missing(relative(named));
      return nullptr;
    }
    opened.push_back(path);
    return DefaultIOSystem::Open(path.c_str(), mode);
  }

  std::vector<std::string> opened;
  std::vector<std::string> missing;

 private:
  // assimp puts the folder before the names that a file gives.
  std::string relative(std::string named) const {
    if (!folder_.empty() && named.starts_with(folder_ + "/")) named.erase(0, folder_.size() + 1);
    if (named.starts_with("./")) named.erase(0, 2);
    return named;
  }
  // assimp looks for a file several times, under shortened names too, and for one with our name.
  void add_missing(const std::string& name) {
    const auto is_same = [&](const std::string& other) { return other.ends_with(name); };
    if (name.starts_with(kName) || std::ranges::any_of(missing, is_same)) return;
    missing.push_back(name);
  }
  std::string beside(const std::string& named) const {
    try {
      return data_file_beside(path_, relative(named));
    } catch (const Error&) {
      return {};
    }
  }

  std::string path_;
  std::string folder_;
  std::string name_;
};

// --- Materials ---

void copy(const aiColor3D& color, double* to) {
  to[0] = color.r;
  to[1] = color.g;
  to[2] = color.b;
}

// glTF's metal and roughness in Phong's terms: a metal reflects its colour at the highlight alone,
// other things 4 % of it, and the lobe of roughness r is about as wide as that of the exponent
// 2 / r^4 - 2. Ambient is an eighth of diffuse, as it is where nothing is said.
void fill_from_gltf(const aiMaterial& from, ImportedMaterial& to) {
  aiColor4D base(1, 1, 1, 1);
  ai_real metallic = 1, roughness = 1;
  from.Get(AI_MATKEY_BASE_COLOR, base);
  from.Get(AI_MATKEY_METALLIC_FACTOR, metallic);
  from.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness);
  const double color[3] = {base.r, base.g, base.b};
  for (int channel = 0; channel < 3; ++channel) {
    to.kd[channel] = color[channel] * (1 - metallic);
    to.ka[channel] = to.kd[channel] / 8;
    to.ks[channel] = 0.04 * (1 - metallic) + color[channel] * metallic;
  }
  const double width = std::max(0.05, static_cast<double>(roughness));
  to.shininess = std::max(1.0, 2 / (width * width * width * width) - 2);
}

// What assimp's OBJ reader holds of a material that is named and nowhere described.
bool says_nothing(const ImportedMaterial& m) {
  constexpr float kDiffuse = 0.6f;
  const auto all = [](const double* c, double value) {
    return c[0] == value && c[1] == value && c[2] == value;
  };
  return all(m.ka, 0) && all(m.kd, kDiffuse) && all(m.ks, 0) && m.shininess == 0;
}

void fill_from_phong(const aiMaterial& from, ImportedMaterial& to) {
  aiColor3D ambient(0, 0, 0), diffuse(0.8f, 0.8f, 0.8f), specular(0, 0, 0);
  ai_real shininess = 0;
  from.Get(AI_MATKEY_COLOR_AMBIENT, ambient);
  from.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
  from.Get(AI_MATKEY_COLOR_SPECULAR, specular);
  from.Get(AI_MATKEY_SHININESS, shininess);
  copy(ambient, to.ka);
  copy(diffuse, to.kd);
  copy(specular, to.ks);
  to.shininess = shininess;
}

void send_material(const aiScene& scene, const aiMaterial& from, const std::string& ending,
                   FenceOutput& output) {
  ImportedMaterial to{};
  aiString name, texture_name;
  from.Get(AI_MATKEY_NAME, name);
  const bool is_gltf = ending == "gltf" || ending == "glb";
  is_gltf ? fill_from_gltf(from, to) : fill_from_phong(from, to);
  // assimp makes a material up where the file gives none.
  const bool is_made_up = name == aiString(AI_DEFAULT_MATERIAL_NAME) || says_nothing(to);
  to.is_given = is_gltf || (ending == "obj" && !is_made_up);
  if (from.GetTexture(aiTextureType_BASE_COLOR, 0, &texture_name) != aiReturn_SUCCESS) {
    from.GetTexture(aiTextureType_DIFFUSE, 0, &texture_name);
  }
  std::string texture = texture_name.C_Str();
  if (const aiTexture* embedded = scene.GetEmbeddedTexture(texture.c_str())) {
    to.is_texture_embedded = 1;
    texture.clear();
    if (embedded->mHeight == 0) {  // then it is a file's bytes, mWidth of them
      texture.assign(reinterpret_cast<const char*>(embedded->pcData), embedded->mWidth);
    }
  }
  output.send(&to, sizeof to);
  output.send_text(name.C_Str());
  output.send_text(texture);
}

// --- Parts ---

Affine affine_of(const aiMatrix4x4& m) {
  return {{{{m.a1, m.b1, m.c1}, {m.a2, m.b2, m.c2}, {m.a3, m.b3, m.c3}}}, {m.a4, m.b4, m.c4}};
}

struct Instance {
  const aiMesh* mesh;
  Affine to_root;
};

void collect(const aiScene& scene, const aiNode& node, const Affine& parent,
             std::vector<Instance>& instances) {
  const Affine own = affine_of(node.mTransformation);
  const Affine to_root{parent.linear * own.linear, parent.point(own.offset)};
  for (unsigned n = 0; n < node.mNumMeshes; ++n) {
    instances.push_back({scene.mMeshes[node.mMeshes[n]], to_root});
  }
  for (unsigned n = 0; n < node.mNumChildren; ++n) {
    collect(scene, *node.mChildren[n], to_root, instances);
  }
}

template <typename T>
void send_all(FenceOutput& output, const std::vector<T>& values) {
  output.send(values.data(), values.size() * sizeof(T));
}

void send_part(const Instance& instance, bool with_normals, FenceOutput& output) {
  const aiMesh& mesh = *instance.mesh;
  // Normals go by the inverse transpose; turned with the winding, they keep to their side.
  const Mat3 for_normals = transpose(inverse(instance.to_root.linear));
  const bool is_mirrored = determinant(instance.to_root.linear) < 0;
  ImportedPart part{};
  part.vertices = mesh.mNumVertices;
  part.material = mesh.mMaterialIndex;
  part.has_normals = with_normals && mesh.HasNormals();
  part.has_texture_points = mesh.HasTextureCoords(0);
  part.has_colors = mesh.HasVertexColors(0);
  std::vector<std::uint32_t> indices;
  for (unsigned n = 0; n < mesh.mNumFaces; ++n) {
    const aiFace& face = mesh.mFaces[n];
    if (face.mNumIndices != 3) {
      ++part.other_faces;
      continue;
    }
    indices.insert(indices.end(), {face.mIndices[0], face.mIndices[is_mirrored ? 2 : 1],
                                   face.mIndices[is_mirrored ? 1 : 2]});
  }
  part.triangles = indices.size() / 3;
  output.send(&part, sizeof part);
  std::vector<Vec3> vectors(mesh.mNumVertices);
  const auto send_vectors = [&](const auto& vector_of) {
    for (unsigned n = 0; n < mesh.mNumVertices; ++n) vectors[n] = vector_of(n);
    send_all(output, vectors);
  };
  const auto as_vec3 = [](const aiVector3D& v) { return Vec3{v.x, v.y, v.z}; };
  send_vectors([&](unsigned n) { return instance.to_root.point(as_vec3(mesh.mVertices[n])); });
  if (part.has_normals) {
    send_vectors([&](unsigned n) { return for_normals * as_vec3(mesh.mNormals[n]); });
  }
  if (part.has_texture_points) {
    send_vectors([&](unsigned n) { return as_vec3(mesh.mTextureCoords[0][n]); });
  }
  if (part.has_colors) {
    send_vectors([&](unsigned n) {
      const aiColor4D& c = mesh.mColors[0][n];
      return Vec3{c.r, c.g, c.b};
    });
  }
  send_all(output, indices);
}

void send_names(FenceOutput& output, const std::vector<std::string>& names) {
  const std::uint64_t count = names.size();
  output.send(&count, sizeof count);
  for (const std::string& name : names) output.send_text(name);
}

}  // namespace

void import_mesh(const MeshFile& file, FenceOutput& output) {
  Assimp::Importer importer;
  auto* files = new MeshFiles(file);
  importer.SetIOHandler(files);  // which owns it
  const aiScene* scene = importer.ReadFile(files->name(), aiProcess_Triangulate);
  if (!scene || !scene->mRootNode) {
    output.send_text(std::string("is damaged: ") + importer.GetErrorString());
    return;
  }
  output.send_text("");
  send_names(output, files->opened);
  send_names(output, files->missing);
  const std::uint64_t materials = scene->mNumMaterials;
  output.send(&materials, sizeof materials);
  for (unsigned n = 0; n < scene->mNumMaterials; ++n) {
    send_material(*scene, *scene->mMaterials[n], file.ending, output);
  }
  std::vector<Instance> instances;
  collect(*scene, *scene->mRootNode, {}, instances);
  const std::uint64_t parts = instances.size();
  output.send(&parts, sizeof parts);
  // An STL's are its facets' own, which would keep them from sharing vertices.
  const bool with_normals = file.ending != "stl";
  for (const Instance& instance : instances) send_part(instance, with_normals, output);
}

}  // namespace isolux
