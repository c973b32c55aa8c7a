#include "drivers/simulator/mesh_file.hpp"

#include <algorithm>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "libs/config/yaml_map.hpp"

namespace fusion_slam {
namespace {

constexpr int kMostTexels = 2048;  // of a picture's side; larger ones are made smaller
constexpr std::array<float, 3> kPlainBgr{0.55F, 0.58F, 0.60F};  // where a picture is missing

Eigen::Matrix4d to_eigen(const aiMatrix4x4& m) {
  Eigen::Matrix4d out;
  out << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3,
      m.d4;
  return out;
}

// Assimp turns COLLADA models so that y is up, whatever the file says: back to z up.
Eigen::Matrix4d z_up(const std::filesystem::path& path) {
  Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
  std::string kind = path.extension().string();
  std::transform(kind.begin(), kind.end(), kind.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (kind == ".dae") turn.topLeftCorner<3, 3>() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return turn;
}

Mesh geometry(const aiMesh& in, const Eigen::Matrix4d& T_model_mesh) {
  const Eigen::Matrix3d A = T_model_mesh.topLeftCorner<3, 3>();
  const Eigen::Matrix3d N = A.inverse().transpose();  // normals stay across surfaces
  Mesh mesh;
  for (unsigned i = 0; i < in.mNumVertices; ++i) {
    const aiVector3D &v = in.mVertices[i], &n = in.mNormals[i];
    mesh.vertices_m.emplace_back(
        (A * Eigen::Vector3d(v.x, v.y, v.z) + T_model_mesh.topRightCorner<3, 1>()).cast<float>());
    const Eigen::Vector3d normal = N * Eigen::Vector3d(n.x, n.y, n.z);
    const double length = normal.norm();
    mesh.normals.emplace_back(length > 0.0 ? (normal / length).cast<float>()
                                           : Eigen::Vector3f(0.0F, 0.0F, 1.0F));
    if (in.HasTextureCoords(0))
      mesh.uv.emplace_back(in.mTextureCoords[0][i].x, in.mTextureCoords[0][i].y);
  }
  const bool mirrored = A.determinant() < 0.0;
  for (unsigned i = 0; i < in.mNumFaces; ++i) {
    const aiFace& f = in.mFaces[i];
    if (f.mNumIndices != 3) continue;
    mesh.triangles.push_back(
        {f.mIndices[0], f.mIndices[mirrored ? 2 : 1], f.mIndices[mirrored ? 1 : 2]});
  }
  return mesh;
}

struct Part {
  unsigned mesh;
  Eigen::Matrix4d T_model_mesh;
};

void collect(const aiNode& node, const Eigen::Matrix4d& T_model_parent, std::vector<Part>* parts) {
  const Eigen::Matrix4d T_model_node = T_model_parent * to_eigen(node.mTransformation);
  for (unsigned i = 0; i < node.mNumMeshes; ++i) parts->push_back({node.mMeshes[i], T_model_node});
  for (unsigned i = 0; i < node.mNumChildren; ++i) collect(*node.mChildren[i], T_model_node, parts);
}

}  // namespace

std::shared_ptr<const MipMap> MeshFiles::picture(const std::filesystem::path& model,
                                                 std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  if (name.rfind("file://", 0) == 0) name = name.substr(7);
  auto file = (model.parent_path() / name).lexically_normal();
  // Many models name their pictures as they lay on their makers' discs.
  for (const char* folder : {"../materials/textures", "."}) {
    if (std::filesystem::is_regular_file(file)) break;
    const auto other = (model.parent_path() / folder / file.filename()).lexically_normal();
    if (std::filesystem::is_regular_file(other)) file = other;
  }
  const auto known = pictures_.find(file.string());
  if (known != pictures_.end()) return known->second;
  std::shared_ptr<const MipMap>& picture = pictures_[file.string()];
  cv::Mat image;
  if (std::filesystem::is_regular_file(file)) image = cv::imread(file.string(), cv::IMREAD_COLOR);
  if (image.empty()) {
    warnings_.push_back(file.string() +
                        (std::filesystem::exists(file) ? ": not a picture that can be read"
                                                       : ": the picture is missing") +
                        "; " + model.filename().string() + " gets a plain colour");
    return picture;
  }
  const double shrink = static_cast<double>(kMostTexels) / std::max(image.cols, image.rows);
  if (shrink < 1.0) cv::resize(image, image, {}, shrink, shrink, cv::INTER_AREA);
  std::vector<Texel> texels;
  texels.reserve(image.total());
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& c = image.at<cv::Vec3b>(y, x);
      texels.push_back({c[0], c[1], c[2], 255});
    }
  picture = std::make_shared<MipMap>(image.cols, image.rows, texels, Beyond::kRepeat);
  return picture;
}

const std::vector<Mesh>& MeshFiles::load(const std::filesystem::path& path) {
  const std::string key = path.lexically_normal().string();
  const auto known = models_.find(key);
  if (known != models_.end()) return known->second;
  if (!std::filesystem::is_regular_file(path))
    throw ConfigError(path.string() + ": there is no such model file; check the path");
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_LINE | aiPrimitiveType_POINT);
  const aiScene* scene = importer.ReadFile(
      path.string(), aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals |
                         aiProcess_JoinIdenticalVertices);
  if (scene == nullptr || scene->mRootNode == nullptr)
    throw ConfigError(path.string() +
                      ": not a model that can be read: " + importer.GetErrorString());
  std::vector<Part> parts;
  collect(*scene->mRootNode, z_up(path), &parts);
  std::vector<Mesh> meshes;
  for (const Part& part : parts) {
    const aiMesh& in = *scene->mMeshes[part.mesh];
    if (in.mNormals == nullptr) continue;
    Mesh mesh = geometry(in, part.T_model_mesh);
    if (mesh.triangles.empty()) continue;
    const aiMaterial& material = *scene->mMaterials[in.mMaterialIndex];
    aiString file;
    aiColor4D diffuse;
    const bool textured = material.GetTextureCount(aiTextureType_DIFFUSE) > 0 &&
                          material.GetTexture(aiTextureType_DIFFUSE, 0, &file) == aiReturn_SUCCESS;
    if (textured && !mesh.uv.empty()) mesh.picture = picture(path, file.C_Str());
    if (mesh.picture)
      mesh.bgr = {1.0F, 1.0F, 1.0F};
    else if (textured)
      mesh.bgr = kPlainBgr;
    else if (material.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) == aiReturn_SUCCESS)
      mesh.bgr = {diffuse.b, diffuse.g, diffuse.r};
    meshes.push_back(std::move(mesh));
  }
  if (meshes.empty()) throw ConfigError(path.string() + ": holds no triangles");
  return models_[key] = std::move(meshes);
}

}  // namespace fusion_slam
