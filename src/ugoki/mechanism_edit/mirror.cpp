#include "ugoki/mechanism_edit/mirror.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "ugoki/mechanism_edit/mirrored_names.h"

namespace ugoki {
namespace {

double negative(double x) { return x == 0 ? 0 : -x; }  // avoids -0, which would appear in written files

/// The reflection S = 1 - 2 n n^T for a coordinate axis n.
struct Mirror {
  int n = 1;

  [[nodiscard]] bool flips(int i) const { return i == n; }
  [[nodiscard]] Vec3 of(Vec3 v) const {
    v[n] = negative(v[n]);
    return v;
  }
  /// -S v: axis of the mirrored rotation, for a rotation about the axis v.
  [[nodiscard]] Vec3 of_axis(Vec3 v) const {
    for (int i = 0; i < 3; ++i)
      if (i != n) v[i] = negative(v[i]);
    return v;
  }
  [[nodiscard]] Mat3 of(const Mat3& R) const {
    const auto row = [&](int i) {
      Vec3 r = R.row(i);
      for (int j = 0; j < 3; ++j)
        if (flips(i) != flips(j)) r[j] = negative(r[j]);
      return r;
    };
    const Vec3 a = row(0), b = row(1), c = row(2);
    return {a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z};
  }
  [[nodiscard]] Pose of(const Pose& X) const { return {of(X.R), of(X.p)}; }
  [[nodiscard]] Sym3 of(Sym3 s) const {
    if (flips(0) != flips(1)) s.xy = negative(s.xy);
    if (flips(0) != flips(2)) s.xz = negative(s.xz);
    if (flips(1) != flips(2)) s.yz = negative(s.yz);
    return s;
  }
  [[nodiscard]] Inertia of(const Inertia& i) const { return {i.mass, of(i.h), of(i.I)}; }

  /// -1 if the coordinate of DOF k changes its sign, else 1.
  [[nodiscard]] double sign(JointType type, int k) const {
    switch (type) {
      case JointType::cylindrical: return k == 1 ? -1 : 1;
      case JointType::planar: return k < 2 ? (flips(k) ? -1 : 1) : (flips(2) ? 1 : -1);
      case JointType::spherical: return flips(k) ? 1 : -1;
      case JointType::floating: return k < 3 ? (flips(k) ? 1 : -1) : (flips(k - 3) ? -1 : 1);
      default: return 1;
    }
  }
};

Joint mirrored(const Joint& joint, const Mirror& S) {
  Joint out = joint;
  out.X_PJ = S.of(joint.X_PJ);
  out.axis = joint.type == JointType::prismatic ? S.of(joint.axis) : S.of_axis(joint.axis);
  out.axis2 = S.of_axis(joint.axis2);
  out.pitch = negative(joint.pitch);
  for (int k = 0; k < joint.nv(); ++k) {
    Dof& f = out.dofs[static_cast<std::size_t>(k)];
    if (S.sign(joint.type, k) > 0) continue;
    const double lower = f.lower;
    f.lower = negative(f.upper);
    f.upper = negative(lower);
    f.rest = negative(f.rest);
  }
  return out;
}

/// Maps each mesh and height field to its mirror image, so that surfaces shared by several shapes are mirrored once.
struct Surfaces {
  std::map<const Geometry*, GeometryPtr> meshes;
  std::map<const HeightField*, HeightFieldPtr> fields;
};

Result<GeometryPtr> mirrored(const GeometryPtr& mesh, const Mirror& S, const std::string& location, Surfaces& done) {
  if (const auto it = done.meshes.find(mesh.get()); it != done.meshes.end()) return it->second;
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  for (const Vec3& v : mesh->vertices) vertices.push_back(S.of(v));
  for (const Triangle& t : mesh->triangles) triangles.push_back({t[0], t[2], t[1]});
  Result<GeometryPtr> out = make_geometry(vertices, triangles, mesh->convex, location);
  if (out) done.meshes.emplace(mesh.get(), *out);
  return out;
}

Result<HeightFieldPtr> mirrored(const HeightFieldPtr& field, const Mirror& S, const std::string& location, Surfaces& done) {
  if (S.n == 2)
    return fail(ErrorCode::unsupported, location, "A height field cannot be mirrored at a horizontal plane (normal z).",
                "Mirror with the normal x or y, or remove the height field first.");
  if (const auto it = done.fields.find(field.get()); it != done.fields.end()) return it->second;
  HeightField image = *field;
  for (int row = 0; row < field->rows; ++row)
    for (int column = 0; column < field->columns; ++column) {
      const int from_row = S.n == 1 ? field->rows - 1 - row : row;
      const int from_column = S.n == 0 ? field->columns - 1 - column : column;
      image.heights[static_cast<std::size_t>(row * field->columns + column)] =
          field->heights[static_cast<std::size_t>(from_row * field->columns + from_column)];
    }
  Result<HeightFieldPtr> out = make_height_field(std::move(image), location);
  if (out) done.fields.emplace(field.get(), *out);
  return out;
}

Result<void> mirror_shapes(LinkSpec& link, const Mirror& S, Surfaces& done) {
  const std::string location = "link " + link.name;
  for (Shape& shape : link.shapes) {
    shape.X_BS = S.of(shape.X_BS);
    if (shape.geometry) {
      Result<GeometryPtr> image = mirrored(shape.geometry, S, location, done);
      if (!image) return fail(std::move(image.error()));
      shape.geometry = std::move(*image);
    }
    if (shape.field) {
      Result<HeightFieldPtr> image = mirrored(shape.field, S, location, done);
      if (!image) return fail(std::move(image.error()));
      shape.field = std::move(*image);
    }
  }
  return {};
}

void mirror_loop(LoopSpec& loop, const MechanismSpec& spec, const Mirror& S) {
  if (loop.type == LoopType::gear) {
    const auto sign = [&](const std::string& link, int dof) {
      const auto it = std::ranges::find_if(spec.links, [&](const LinkSpec& l) { return l.name == link; });
      return S.sign(it->joint.type, dof);
    };
    double s = sign(loop.link_a, loop.dof_a);
    const double s_b = sign(loop.link_b, loop.dof_b);
    for (double& c : loop.polynomial) {
      if (s < 0) c = negative(c);
      s *= s_b;
    }
    return;
  }
  loop.X_AJ = S.of(loop.X_AJ);
  loop.X_BJ = S.of(loop.X_BJ);
  // Loop constraints depend only on the line of an axis, not on its direction, so S a and -S a are equivalent.
  loop.axis = S.of(loop.axis);
  loop.axis2 = S.of(loop.axis2);
}

void swap_names(MechanismSpec& spec) {
  std::vector<std::string> links, loops;
  for (const LinkSpec& l : spec.links) links.push_back(l.name);
  for (const LoopSpec& l : spec.loops) loops.push_back(l.name);
  const std::vector<std::string> new_links = mirrored_names(links), new_loops = mirrored_names(loops);
  std::map<std::string, std::string, std::less<>> renamed;
  for (std::size_t i = 0; i < links.size(); ++i) renamed.emplace(links[i], new_links[i]);
  const auto rename = [&](std::string& name) {
    if (const auto it = renamed.find(name); it != renamed.end()) name = it->second;
  };
  for (LinkSpec& l : spec.links) {
    rename(l.name);
    rename(l.parent);
    rename(l.real);
    l.label = mirrored_word(l.label);
  }
  for (std::size_t i = 0; i < spec.loops.size(); ++i) {
    rename(spec.loops[i].link_a);
    rename(spec.loops[i].link_b);
    spec.loops[i].name = new_loops[i];
  }
  for (auto& exclusion : spec.exclusions) std::ranges::for_each(exclusion, rename);
  for (SkinBone& bone : spec.skin_bones) rename(bone.link);
}

}  // namespace

Result<Edited> mirror(const Mechanism& m, const MirrorOptions& options) {
  const Mirror S{options.normal};
  MechanismSpec spec = m.spec();
  Surfaces done;
  bool had_prepared = false;
  for (LoopSpec& loop : spec.loops) mirror_loop(loop, spec, S);
  for (LinkSpec& link : spec.links) {
    for (const Shape& s : link.shapes) had_prepared = had_prepared || (s.geometry && s.geometry->prepared);
    link.joint = mirrored(link.joint, S);
    link.inertia = S.of(link.inertia);
    link.X_RV = S.of(link.X_RV);
    if (Result<void> shapes = mirror_shapes(link, S, done); !shapes) return fail(std::move(shapes.error()));
  }
  for (SkinBone& bone : spec.skin_bones) {
    bone.A = Mat3::columns(S.of(bone.A.column(0)), S.of(bone.A.column(1)), S.of(bone.A.column(2)));
    bone.p = S.of(bone.p);
  }
  if (options.swap_sides) swap_names(spec);
  Edited out;
  if (had_prepared) out.report.push_back("The collision data precomputed for the meshes was dropped; it is recomputed on import.");
  Result<MechanismPtr> made = Mechanism::make(std::move(spec));
  if (!made) return fail(std::move(made.error()));
  out.mechanism = std::move(*made);
  return out;
}

void mirror_position(const Mechanism& m, std::span<const double> q, std::span<double> out, const MirrorOptions& options) {
  const Mirror S{options.normal};
  for (const Link& link : m.links()) {
    const std::size_t at = static_cast<std::size_t>(link.q_index);
    const JointType type = link.joint.type;
    if (type == JointType::spherical || type == JointType::floating) {
      const std::size_t turn = type == JointType::floating ? at + 3 : at;
      for (int k = 0; k < 3 && type == JointType::floating; ++k)
        out[at + static_cast<std::size_t>(k)] = q[at + static_cast<std::size_t>(k)] * S.sign(type, 3 + k);
      out[turn] = q[turn];
      for (int k = 0; k < 3; ++k)
        out[turn + 1 + static_cast<std::size_t>(k)] = q[turn + 1 + static_cast<std::size_t>(k)] * (S.flips(k) ? 1 : -1);
      continue;
    }
    for (int k = 0; k < link.joint.nq(); ++k) out[at + static_cast<std::size_t>(k)] = q[at + static_cast<std::size_t>(k)] * S.sign(type, k);
  }
}

}  // namespace ugoki
