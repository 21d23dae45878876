// Mesh files: formats, units, axes, materials, and damaged files.

#include "ugoki/scene_formats/mesh_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "ugoki/base/base64.h"

namespace ugoki::scene_formats {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text.data(), text.size())); }

MeshScene read(std::string_view text, std::string_view name, const MeshOptions& options = {}, formats::ReadNotes* notes = nullptr) {
  Result<MeshScene> scene = read_mesh_scene(bytes_of(text), name, options, notes);
  EXPECT_TRUE(scene) << (scene ? "" : scene.error().text());
  return scene ? std::move(*scene) : MeshScene{};
}
void refused(std::string_view text, std::string_view name, const std::string& word) {
  const Result<MeshScene> scene = read_mesh_scene(bytes_of(text), name);
  ASSERT_FALSE(scene) << name;
  const Problem& p = scene.error().problems.front();
  EXPECT_EQ(p.location, name);
  EXPECT_NE((p.message + p.remedy).find(word), std::string::npos) << p.message << " " << p.remedy;
  EXPECT_FALSE(p.remedy.empty());
}

/// Volume enclosed by all triangles, m^3.
double volume_of(const MeshScene& scene) {
  double sum = 0;
  for (const MeshPart& part : scene.parts)
    for (const Triangle& t : part.triangles) {
      const auto at = [&](std::size_t k) { return scene.vertices[static_cast<std::size_t>(t[k])]; };
      sum += dot(at(0), cross(at(1), at(2))) / 6;
    }
  return sum;
}

/// A tetrahedron with the corners 0, x, y, z; its faces as OBJ, the last two in another material.
const std::string tetrahedron = R"(mtllib some/folder/paint.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
usemtl red
f 1 3 2
f 1 2 4
usemtl blue
f 1 4 3
f 2 3 4
)";

TEST(MeshScene, ObjHasTheColoursOfItsMaterialFile) {
  formats::ReadNotes notes;
  const MeshOptions options{.companions = [](std::string_view name) -> Result<std::vector<std::byte>> {
    if (name != "paint.mtl") return fail(ErrorCode::io, std::string(name), "missing");
    const auto bytes = bytes_of("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 0.5\n");
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  }};
  const MeshScene scene = read(tetrahedron, "a.obj", options, &notes);
  ASSERT_EQ(scene.parts.size(), 2U);
  EXPECT_EQ(scene.parts[0].color, "#000080");
  EXPECT_EQ(scene.parts[1].color, "#ff0000");
  EXPECT_NEAR(volume_of(scene), 1.0 / 6, 1e-9);
  EXPECT_FALSE(notes.z_up);
  EXPECT_TRUE(notes.unit_guessed);
  // without its material file it has no colours, and the user learns why
  notes = {};
  EXPECT_EQ(read(tetrahedron, "a.obj", {}, &notes).parts[0].color, "");
  EXPECT_NE(notes.remarks.front().find("paint.mtl"), std::string::npos) << notes.remarks.front();
}

TEST(MeshScene, NoFileIsOpenedExceptThoseThatAreGiven) {
  std::vector<std::string> asked;
  const MeshOptions options{.companions = [&](std::string_view name) -> Result<std::vector<std::byte>> {
    return fail(ErrorCode::io, std::string(name), "missing");
  }};
  EXPECT_EQ(read("mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj", options).parts.size(), 1U);
}

TEST(MeshScene, StlIsZUpAndMillimetresIfLarge) {
  const std::string text =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 100\nvertex 2000 0 100\nvertex 0 500 100\nendloop\nendfacet\nendsolid a\n";
  formats::ReadNotes notes;
  const MeshScene scene = read(text, "a.STL", {}, &notes);
  EXPECT_TRUE(notes.z_up);
  EXPECT_TRUE(notes.unit_guessed);
  EXPECT_EQ(notes.metres_per_unit, 0.001);
  EXPECT_NEAR(scene.vertices[0].z, 0.1, 1e-6);
  EXPECT_NEAR(read(text, "a.stl", {.metres_per_unit = 0.01}).vertices[0].z, 1, 1e-6);
}

TEST(MeshScene, PlyHasTheMeanOfItsColours) {
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
      "green\n"
      "property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 255 0 0\n0 1 0 255 0 "
      "0\n3 0 1 2\n";
  const MeshScene scene = read(text, "a.ply");
  EXPECT_EQ(scene.parts[0].color, "#ff0000");
  EXPECT_EQ(scene.parts[0].triangles.size(), 1U);
}

/// A glTF text: a tetrahedron on a node that is moved, enlarged and mirrored, below a turned node.
std::string gltf(const std::string& indices_count = "12", const std::string& more = "") {
  const std::vector<float> points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<std::uint16_t> corners = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  std::string data(reinterpret_cast<const char*>(points.data()), 48);
  data.append(reinterpret_cast<const char*>(corners.data()), 24);
  const std::string packed = to_base64({reinterpret_cast<const std::uint8_t*>(data.data()), data.size()});
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"children": [1], "rotation": [0, 0.7071068, 0, 0.7071068]}, {"mesh": 0, "translation": [2, 0, 0], "scale": [3, 1, -2]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.2159, 0, 1]}}],
    "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64,)" +
         packed + R"("}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
                  {"bufferView": 1, "componentType": 5123, "count": )" +
         indices_count + R"(, "type": "SCALAR"}])" + more + "}";
}

TEST(MeshScene, GltfNodesMoveScaleAndMirror) {
  formats::ReadNotes notes;
  const MeshScene scene = read(gltf(), "a.gltf", {}, &notes);
  ASSERT_EQ(scene.parts.size(), 1U);
  EXPECT_EQ(scene.parts[0].color, "#ff8000") << "base colours of glTF are linear";
  EXPECT_NEAR(volume_of(scene), 1, 1e-6) << "the mirrored triangles still face outwards";
  EXPECT_FALSE(notes.unit_guessed);
  EXPECT_FALSE(scene.skinned);
  // (0, 0, 0) is at (2, 0, 0) of the turned node: at z = -2 of the file, which is x = -2 here
  EXPECT_NEAR(norm(scene.vertices[0] - Vec3{-2, 0, 0}), 0, 1e-6);
  // (0, 1, 0) of the file is one metre higher
  EXPECT_NEAR(norm(scene.vertices[2] - Vec3{-2, 0, 1}), 0, 1e-6);
}

/// A PNG picture of one pixel, in base64.
const std::string pixel = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";

/// A glTF text: a triangle with normals and texture coordinates on a node that is stretched, whose texture is transformed.
std::string textured_gltf(const std::string& image, const std::string& transform = "") {
  const std::vector<float> numbers = {0,     0,    0,    1,    0, 0,    0, 1, 0,  // positions
                                      0.6F,  0,    0.8F, 0.6F, 0, 0.8F, 0, 0, 1,  // normals
                                      0.25F, 0.5F, 1,    0,    0, 0.75F};         // texture coordinates
  const std::string packed = to_base64({reinterpret_cast<const std::uint8_t*>(numbers.data()), 4 * numbers.size()});
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "extensionsUsed": ["KHR_texture_transform"],
    "nodes": [{"mesh": 0, "scale": [2, 1, -1]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}, "material": 0}]}],
    "materials": [{"doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
      "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 0, 1], "baseColorTexture": {"index": 0)" +
         transform + R"(}}}],
    "textures": [{"source": 0}], "images": [)" +
         image + R"(],
    "buffers": [{"byteLength": 96, "uri": "data:application/octet-stream;base64,)" +
         packed + R"("}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 36}, {"buffer": 0, "byteOffset": 72, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
                  {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"},
                  {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2"}]})";
}

TEST(MeshScene, GltfHasItsTextures) {
  const MeshScene scene = read(textured_gltf(R"({"uri": "data:image/png;base64,)" + pixel + R"("})"), "a.gltf");
  ASSERT_EQ(scene.parts.size(), 1U);
  const MeshPart& part = scene.parts[0];
  EXPECT_EQ(part.texture, 0);
  EXPECT_EQ(part.tint, "#ffff00");
  EXPECT_EQ(part.cutoff, 0.25);
  EXPECT_TRUE(part.both_sides);
  ASSERT_EQ(scene.textures.size(), 1U);
  EXPECT_EQ(scene.textures[0].type, "image/png");
  EXPECT_EQ(to_base64({reinterpret_cast<const std::uint8_t*>(scene.textures[0].data.data()), scene.textures[0].data.size()}), pixel);
  EXPECT_EQ(scene.uvs, (std::vector<float>{0.25F, 0.5F, 1, 0, 0, 0.75F})) << "from the top left corner, as in glTF";
  // the inverse transpose of diag(2, 1, -1) turns (0.6, 0, 0.8) to (0.3, 0, -0.8); y of the file is our z, z is our x, x is our y
  EXPECT_NEAR(norm(scene.normals[0] - normalized(Vec3{-0.8, 0.3, 0})), 0, 1e-6);
  EXPECT_NEAR(norm(scene.normals[2] - Vec3{-1, 0, 0}), 0, 1e-6);
}

TEST(MeshScene, TransformsOfTexturesAreInTheirCoordinates) {
  const MeshScene scene =
      read(textured_gltf(R"({"uri": "data:image/png;base64,)" + pixel + R"("})",
                         R"(, "extensions": {"KHR_texture_transform": {"offset": [0.1, 0.2], "scale": [2, 3], "rotation": 0.5}})"),
           "a.gltf");
  ASSERT_EQ(scene.uvs.size(), 6U);
  const float plain[] = {0.25F, 0.5F, 1, 0, 0, 0.75F};
  for (std::size_t v = 0; v < 3; ++v) {
    const double x = 2 * static_cast<double>(plain[2 * v]), y = 3 * static_cast<double>(plain[2 * v + 1]);
    EXPECT_NEAR(static_cast<double>(scene.uvs[2 * v]), std::cos(0.5) * x + std::sin(0.5) * y + 0.1, 1e-5) << v;
    EXPECT_NEAR(static_cast<double>(scene.uvs[2 * v + 1]), -std::sin(0.5) * x + std::cos(0.5) * y + 0.2, 1e-5) << v;
  }
}

TEST(MeshScene, TexturesBesideTheFileAreReadOrReported) {
  const std::string text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl wood\nf 1/1 2/2 3/3\n";
  const auto options = [](bool with_picture) {
    return MeshOptions{.companions = [with_picture](std::string_view name) -> Result<std::vector<std::byte>> {
      if (name == "a.mtl") {
        const auto bytes = bytes_of("newmtl wood\nKd 0.8 0.8 0.8\nmap_Kd textures/wood.png\n");
        return std::vector<std::byte>(bytes.begin(), bytes.end());
      }
      if (name != "wood.png" || !with_picture) return fail(ErrorCode::io, std::string(name), "missing");
      const std::vector<std::uint8_t> bytes = from_base64(pixel).value();
      const auto* data = reinterpret_cast<const std::byte*>(bytes.data());
      return std::vector<std::byte>(data, data + bytes.size());
    }};
  };
  formats::ReadNotes notes;
  const MeshScene scene = read(text, "a.obj", options(true), &notes);
  EXPECT_EQ(scene.parts.at(0).texture, 0);
  EXPECT_EQ(scene.parts.at(0).tint, "#ffffff") << "the picture replaces the grey of the material";
  EXPECT_EQ(scene.parts.at(0).color, "#cccccc");
  EXPECT_EQ(scene.uvs, (std::vector<float>{0, 1, 1, 1, 0, 0}));
  for (const std::string& r : notes.remarks) EXPECT_EQ(r.find("texture"), std::string::npos) << r;
  notes = {};
  const MeshScene bare = read(text, "a.obj", options(false), &notes);
  EXPECT_EQ(bare.parts.at(0).texture, -1);
  EXPECT_EQ(bare.parts.at(0).tint, "#cccccc");
  EXPECT_NE(notes.remarks.back().find("wood.png"), std::string::npos) << notes.remarks.back();
}

TEST(MeshScene, ColladaHasUnitAndUpAxis) {
  const auto text = [](const std::string& up, const std::string& color) {
    return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit name="inch" meter="0.0254"/><up_axis>)" +
           up + R"(</up_axis></asset><library_effects><effect id="e"><profile_COMMON><technique sid="t"><lambert><diffuse><color>)" +
           color +
           R"(</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects><library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 100 0 0 0 0 100</float_array><technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"><bind_material><technique_common><instance_material symbol="s" target="#m"/></technique_common></bind_material></instance_geometry></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  };
  const MeshScene z = read(text("Z_UP", "0 1 0 1"), "a.dae");
  EXPECT_EQ(z.parts[0].color, "#00ff00");
  EXPECT_NEAR(z.vertices[2].z, 2.54, 1e-6);
  const MeshScene y = read(text("Y_UP", "0 1 0 1"), "a.dae");
  EXPECT_NEAR(y.vertices[2].x, 2.54, 1e-6);
}

TEST(MeshScene, DamagedFilesAreRefusedWithARemedy) {
  refused("", "a.glb", "Export");
  refused("glTF", "a.glb", "Export");
  refused("not a mesh", "a.obj", "Export");
  refused("v 0 0 0\nv 1 0 0\n", "a.obj", "Export");
  refused("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj", "xport");
  refused("solid a\nendsolid a\n", "a.stl", "Export");
  refused("ply\nformat ascii 1.0\nelement vertex 1000000\nend_header\n", "a.ply", "Export");
  refused(gltf("12000"), "a.gltf", "Export");
  refused("hello", "a.blend", ".glb");
  // a file that is cut off, or in which bytes are changed, is read or refused; this process survives
  const std::string whole = gltf();
  std::mt19937 random(7);
  for (int i = 0; i < 40; ++i) {
    std::string text = i % 2 == 0 ? whole.substr(0, random() % whole.size()) : whole;
    for (int k = 0; i % 2 == 1 && k < 4; ++k) text[random() % text.size()] = static_cast<char>(random());
    (void)read_mesh_scene(bytes_of(text), "a.gltf", {.seconds = 5});
  }
}

}  // namespace
}  // namespace ugoki::scene_formats
