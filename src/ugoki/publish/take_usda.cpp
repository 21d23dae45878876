#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "ugoki/base/check.h"
#include "ugoki/publish/number_text.h"
#include "ugoki/publish/shape_surface.h"
#include "ugoki/publish/take.h"
#include "ugoki/publish/usda_physics.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::publish {
namespace {

Pose pose_of(const content::DisplayPose& x) { return {to_matrix(x.r), x.p}; }

class Writer {
 public:
  explicit Writer(const Take& take) : take_(take) {}

  std::string write() {
    std::set<std::string> used = {"Camera", "Content"};
    out_ = "#usda 1.0\n(\n    defaultPrim = \"Content\"\n    doc = \"Written by Ugoki\"\n    endTimeCode = " +
           std::to_string(take_.frames - 1) + "\n    metersPerUnit = 1\n    startTimeCode = 0\n    timeCodesPerSecond = ";
    add_number(out_, take_.rate);
    out_ += "\n    upAxis = \"Z\"\n)\n\ndef Xform \"Content\"\n{\n";
    for (const TakeCharacter& c : take_.characters)
      if (c.links() > 0) {
        const std::string name = usd_name(c.name.empty() ? c.id : c.name, used);
        add_character(c, name);
        std::vector<Pose> poses;
        for (std::size_t l = 0; l < c.links(); ++l) poses.push_back(pose_of(c.pose(0, l)));
        out_ += usda_physics(*c.mechanism, poses, usd_name(name + "_physics", used));
      }
    out_ += "    def PhysicsScene \"" + usd_name("PhysicsScene", used) + "\"\n    {\n        vector3f physics:gravityDirection = ";
    const double gravity = norm(take_.gravity);
    vec(gravity > 0 ? take_.gravity / gravity : Vec3{0, 0, -1});
    out_ += "\n        float physics:gravityMagnitude = ";
    add_number(out_, gravity);
    out_ += "\n    }\n\n";
    add_camera();
    out_ += "}\n";
    return std::move(out_);
  }

 private:
  void vec(const Vec3& v) {
    out_ += '(';
    for (int k = 0; k < 3; ++k) {
      if (k > 0) out_ += ", ";
      add_number(out_, v[k]);
    }
    out_ += ')';
  }
  void quat(const Quat& q) {
    out_ += '(';
    const double x[4] = {q.w, q.x, q.y, q.z};
    for (int k = 0; k < 4; ++k) {
      if (k > 0) out_ += ", ";
      add_number(out_, x[k]);
    }
    out_ += ')';
  }
  /// Writes a pose as a matrix of USD. USD multiplies row vectors, so the first three rows are the axes and the last row is the position.
  void matrix(const Pose& X) {
    out_ += "( ";
    for (int r = 0; r < 3; ++r) {
      const Vec3 axis = X.R.column(r);
      out_ += '(';
      for (int k = 0; k < 3; ++k) {
        add_number(out_, axis[k]);
        out_ += ", ";
      }
      out_ += "0), ";
    }
    out_ += '(';
    for (int k = 0; k < 3; ++k) {
      add_number(out_, X.p[k]);
      out_ += ", ";
    }
    out_ += "1) )";
  }
  template <class List, class Write>
  void list(const List& values, Write&& write) {
    out_ += '[';
    bool first = true;
    for (const auto& value : values) {
      if (!first) out_ += ", ";
      first = false;
      write(value);
    }
    out_ += "]";
  }

  void add_character(const TakeCharacter& c, const std::string& name) {
    // USD names a joint by its path from the root.
    std::vector<std::string> paths;
    std::set<std::string> used;
    for (std::size_t l = 0; l < c.links(); ++l) {
      const Link& link = c.mechanism->link(static_cast<int>(l));
      const std::string own = usd_name(link.name, used);
      paths.push_back(link.parent >= 0 ? paths[static_cast<std::size_t>(link.parent)] + '/' + own : own);
    }
    const auto local = [&](int f, std::size_t l) {
      const int parent = c.mechanism->link(static_cast<int>(l)).parent;
      const Pose X = pose_of(c.pose(f, l));
      return parent >= 0 ? pose_of(c.pose(f, static_cast<std::size_t>(parent))).inverse() * X : X;
    };
    std::vector<std::size_t> all(c.links());
    for (std::size_t l = 0; l < all.size(); ++l) all[l] = l;
    out_ += "    def SkelRoot \"" + name + "\" (\n        prepend apiSchemas = [\"SkelBindingAPI\"]\n    )\n    {\n";
    out_ +=
        "        def Skeleton \"Skeleton\" (\n            prepend apiSchemas = [\"SkelBindingAPI\"]\n        )\n        {\n            "
        "uniform token[] joints = ";
    list(paths, [&](const std::string& p) { out_ += '"' + p + '"'; });
    out_ += "\n            uniform matrix4d[] bindTransforms = ";
    list(all, [&](std::size_t l) { matrix(pose_of(c.pose(0, l))); });
    out_ += "\n            uniform matrix4d[] restTransforms = ";
    list(all, [&](std::size_t l) { matrix(local(0, l)); });
    out_ += "\n            rel skel:animationSource = </Content/" + name + "/Animation>\n        }\n\n";
    out_ += "        def SkelAnimation \"Animation\"\n        {\n            uniform token[] joints = ";
    list(paths, [&](const std::string& p) { out_ += '"' + p + '"'; });
    out_ += "\n            half3[] scales = ";
    list(all, [&](std::size_t) { out_ += "(1, 1, 1)"; });
    out_ += "\n            float3[] translations.timeSamples = {\n";
    for (int f = 0; f < take_.frames; ++f) {
      out_ += "                " + std::to_string(f) + ": ";
      list(all, [&](std::size_t l) { vec(local(f, l).p); });
      out_ += ",\n";
    }
    out_ += "            }\n            quatf[] rotations.timeSamples = {\n";
    std::vector<Quat> before(c.links());
    for (int f = 0; f < take_.frames; ++f) {
      out_ += "                " + std::to_string(f) + ": ";
      list(all, [&](std::size_t l) {
        Quat q = to_quat(local(f, l).R);
        if (f > 0 && q.w * before[l].w + dot(q.vec(), before[l].vec()) < 0) q = {-q.w, -q.x, -q.y, -q.z};
        before[l] = q;
        quat(q);
      });
      out_ += ",\n";
    }
    out_ += "            }\n        }\n\n";
    add_mesh(c, name);
    out_ += "    }\n\n";
  }

  void add_mesh(const TakeCharacter& c, const std::string& name) {
    std::vector<Vec3> points, normals;
    std::vector<std::uint32_t> indices;
    std::vector<std::size_t> owners;
    for (std::size_t l = 0; l < c.links(); ++l) {
      const Surface surface = link_surface(c.mechanism->link(static_cast<int>(l)));
      const Pose X = pose_of(c.pose(0, l));
      const auto base = static_cast<std::uint32_t>(points.size());
      for (std::size_t i = 0; i < surface.points.size(); ++i) {
        points.push_back(X.R * surface.points[i] + X.p);
        normals.push_back(X.R * surface.normals[i]);
        owners.push_back(l);
      }
      for (const auto& t : surface.triangles)
        for (const std::uint32_t i : t) indices.push_back(base + i);
    }
    if (indices.empty()) return;
    Vec3 low = points[0], high = points[0];
    for (const Vec3& p : points)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    out_ +=
        "        def Mesh \"Surface\" (\n            prepend apiSchemas = [\"SkelBindingAPI\", \"MaterialBindingAPI\"]\n        )\n        "
        "{\n";
    out_ += "            float3[] extent = [";
    vec(low);
    out_ += ", ";
    vec(high);
    out_ += "]\n            int[] faceVertexCounts = ";
    list(std::vector<int>(indices.size() / 3, 3), [&](int n) { out_ += std::to_string(n); });
    out_ += "\n            int[] faceVertexIndices = ";
    list(indices, [&](std::uint32_t i) { out_ += std::to_string(i); });
    out_ += "\n            point3f[] points = ";
    list(points, [&](const Vec3& p) { vec(p); });
    out_ += "\n            normal3f[] normals = ";
    list(normals, [&](const Vec3& n) { vec(n); });
    out_ += " (\n                interpolation = \"vertex\"\n            )\n            uniform token subdivisionScheme = \"none\"\n";
    out_ += "            matrix4d primvars:skel:geomBindTransform = ";
    matrix({});
    out_ += "\n            int[] primvars:skel:jointIndices = ";
    list(owners, [&](std::size_t l) { out_ += std::to_string(l); });
    out_ +=
        " (\n                elementSize = 1\n                interpolation = \"vertex\"\n            )\n            float[] "
        "primvars:skel:jointWeights = ";
    list(owners, [&](std::size_t) { out_ += '1'; });
    out_ += " (\n                elementSize = 1\n                interpolation = \"vertex\"\n            )\n";
    out_ += "            rel skel:skeleton = </Content/" + name + "/Skeleton>\n            rel material:binding = </Content/" + name +
            "/Material>\n        }\n\n";
    const auto value = [&](std::size_t at) {
      const auto digit = [](char x) { return x >= 'a' ? x - 'a' + 10 : x >= 'A' ? x - 'A' + 10 : x - '0'; };
      return c.color.size() < at + 2 ? 0.8 : (16 * digit(c.color[at]) + digit(c.color[at + 1])) / 255.0;
    };
    out_ +=
        "        def Material \"Material\"\n        {\n            token outputs:surface.connect = </Content/" + name +
        "/Material/Shader.outputs:surface>\n\n            def Shader \"Shader\"\n            {\n                uniform token info:id = "
        "\"UsdPreviewSurface\"\n                color3f inputs:diffuseColor = ";
    const auto linear = [](double s) { return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4); };
    vec({linear(value(1)), linear(value(3)), linear(value(5))});
    out_ +=
        "\n                float inputs:metallic = 0\n                float inputs:roughness = 0.58\n                token "
        "outputs:surface\n            }\n        }\n";
  }

  void add_camera() {
    // The aperture, in tenths of a scene unit, follows from the focal length 50, the camera's vertical angle of view, and the ratio 16:9.
    const double vertical = 2 * 50 * std::tan(take_field_of_view / 2);
    out_ += "    def Camera \"Camera\"\n    {\n        float focalLength = 50\n        float horizontalAperture = ";
    add_number(out_, vertical * 16 / 9);
    out_ += "\n        float verticalAperture = ";
    add_number(out_, vertical);
    out_ += "\n        float2 clippingRange = (0.05, 1000)\n        matrix4d xformOp:transform.timeSamples = {\n";
    for (int f = 0; f < take_.frames; ++f) {
      const TakeView v = view_at(take_, f);
      const Mat3 R = {v.right.x, v.up.x, v.back.x, v.right.y, v.up.y, v.back.y, v.right.z, v.up.z, v.back.z};
      out_ += "            " + std::to_string(f) + ": ";
      matrix({R, v.position});
      out_ += ",\n";
    }
    out_ += "        }\n        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n";
  }

  const Take& take_;
  std::string out_;
};

}  // namespace

std::string write_take_usda(const Take& take) {
  UGOKI_CHECK(take.frames > 0);
  return Writer(take).write();
}

}  // namespace ugoki::publish
