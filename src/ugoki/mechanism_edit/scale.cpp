#include "ugoki/mechanism_edit/scale.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ugoki {
namespace {

/// The affine map A = across 1 + (along - across) u u^T, with the bone's unit direction u.
Mat3 affine(const LinkScale& s, const Vec3& u) {
  return Mat3::diagonal(s.across, s.across, s.across) + Mat3::outer(u, u) * (s.along - s.across);
}

/// Mass properties after the map x -> A x with masses scaled by `mass`: P' = mass A P A with the second moments P = tr(I)/2 1 - I about the
/// origin.
Inertia mapped(const Inertia& i, const Mat3& A, double mass) {
  const double half = 0.5 * (i.I.xx + i.I.yy + i.I.zz);
  const Sym3 P = Sym3{half, half, half, 0, 0, 0} - i.I;
  const Sym3 Q = symmetric_part(A * (P.matrix() * A)) * mass;  // A is symmetric
  const double trace = Q.xx + Q.yy + Q.zz;
  return {i.mass * mass, A * i.h * mass, Sym3{trace, trace, trace, 0, 0, 0} - Q};
}

Result<GeometryPtr> mapped(const Geometry& mesh, const Mat3& A, const std::string& location) {
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) vertices.push_back(A * v);
  return make_geometry(vertices, mesh.triangles, mesh.convex, location);
}

/// Factor by which A changes lengths along axis i of a shape's frame with the orientation R.
double factor_along(const Mat3& A, const Mat3& R, int i) { return norm(A * R.column(i)); }

Result<void> scale_shape(Shape& s, const Mat3& A, const std::string& location) {
  const double x = factor_along(A, s.X_BS.R, 0), y = factor_along(A, s.X_BS.R, 1), z = factor_along(A, s.X_BS.R, 2);
  const Mat3 in_shape = s.X_BS.R.transposed() * (A * s.X_BS.R);
  s.X_BS.p = A * s.X_BS.p;
  switch (s.type) {
    case ShapeType::sphere: s.radius *= pow(A.determinant(), 1.0 / 3); break;
    case ShapeType::capsule:
    case ShapeType::cylinder:
      s.radius *= std::sqrt(x * y);
      s.half_length *= z;
      break;
    case ShapeType::box:
    case ShapeType::ellipsoid: s.half_extents = {s.half_extents.x * x, s.half_extents.y * y, s.half_extents.z * z}; break;
    case ShapeType::mesh: {
      Result<GeometryPtr> mesh = mapped(*s.geometry, in_shape, location);
      if (!mesh) return fail(std::move(mesh.error()));
      s.geometry = std::move(*mesh);
      break;
    }
    case ShapeType::height_field: {
      HeightField field = *s.field;
      field.half_x *= x;
      field.half_y *= y;
      field.base *= z;
      for (double& h : field.heights) h *= z;
      Result<HeightFieldPtr> made = make_height_field(std::move(field), location);
      if (!made) return fail(std::move(made.error()));
      s.field = std::move(*made);
      break;
    }
  }
  return {};
}

/// True if DOF k of the joint type is a displacement (m), false if it is a rotation (rad).
bool is_displacement(JointType type, int k) {
  return type == JointType::prismatic || (type == JointType::cylindrical && k == 1) || (type == JointType::planar && k < 2) ||
         (type == JointType::floating && k >= 3);
}

/// Scales limits, springs and forces of a joint by dynamic similarity. @param l, m factors of length and of the total mass
void scale_forces(Joint& joint, double l, double m) {
  const double root = std::sqrt(l);
  for (int k = 0; k < joint.nv(); ++k) {
    Dof& f = joint.dofs[static_cast<std::size_t>(k)];
    if (is_displacement(joint.type, k)) {
      f.lower *= l;
      f.upper *= l;
      f.rest *= l;
      f.stiffness *= m / l;
      f.damping *= m / root;
      f.armature *= m;
      f.friction *= m;
      f.effort *= m;
    } else {
      f.stiffness *= m * l;
      f.damping *= m * l * root;
      f.armature *= m * l * l;
      f.friction *= m * l;
      f.effort *= m * l;
    }
  }
}

bool usable(double x) { return std::isfinite(x) && x > 0; }

}  // namespace

std::vector<Vec3> bone_directions(const Mechanism& m) {
  const std::size_t n = static_cast<std::size_t>(m.link_count());
  std::vector<double> behind(n, 0.0);
  for (std::size_t i = n; i-- > 0;) {
    behind[i] += m.links()[i].inertia.mass;
    if (m.links()[i].parent >= 0) behind[static_cast<std::size_t>(m.links()[i].parent)] += behind[i];
  }
  std::vector<Vec3> out(n);
  std::vector<double> best(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const Link& l = m.links()[i];
    if (norm(out[i]) == 0 && best[i] == 0) out[i] = normalized(l.inertia.centre(), {});
    if (l.parent < 0) continue;
    const std::size_t p = static_cast<std::size_t>(l.parent);
    if (behind[i] > best[p] && norm(l.joint.X_PJ.p) > 1e-9) {
      best[p] = behind[i];
      out[p] = normalized(l.joint.X_PJ.p);
    }
  }
  return out;
}

Result<Edited> scale_links(const Mechanism& m, std::span<const LinkScale> scales) {
  const std::string location = "mechanism " + m.name();
  for (const LinkScale& s : scales)
    if (!usable(s.along) || !usable(s.across) || !usable(s.mass))
      return fail(ErrorCode::range, location, "A factor of size or mass is not finite and above 0.",
                  "Use factors, heights and masses above 0.");
  MechanismSpec spec = m.spec();
  const std::vector<Vec3> bones = bone_directions(m);
  double mass = 0;
  for (std::size_t i = 0; i < scales.size(); ++i) mass += scales[i].mass * m.links()[i].inertia.mass;
  const double mass_factor = m.mass() > 0 ? mass / m.mass() : 1;
  const auto map_of = [&](int link) {
    return link < 0 ? Mat3::identity() : affine(scales[static_cast<std::size_t>(link)], bones[static_cast<std::size_t>(link)]);
  };
  Edited out;
  bool had_prepared = false;
  for (std::size_t i = 0; i < spec.links.size(); ++i) {
    LinkSpec& link = spec.links[i];
    const Link& was = m.links()[i];
    const LinkScale& own = scales[i];
    // The position of a joint to the world scales with the link itself, so that a standing mechanism stays on the ground.
    const Mat3 A = map_of(static_cast<int>(i)),
               A_parent = was.parent < 0 ? Mat3::diagonal(own.along, own.along, own.along) : map_of(was.parent);
    link.joint.X_PJ.p = A_parent * link.joint.X_PJ.p;
    const double l = was.parent < 0 ? own.along : scales[static_cast<std::size_t>(was.parent)].along;
    link.joint.pitch *= l;
    scale_forces(link.joint, l, mass_factor);
    link.inertia = mapped(link.inertia, A, own.mass);
    for (Shape& s : link.shapes) {
      had_prepared = had_prepared || (s.geometry && s.geometry->prepared);
      if (Result<void> done = scale_shape(s, A, "link " + link.name); !done) return fail(std::move(done.error()));
    }
    if (was.real >= 0) link.X_RV.p = map_of(was.real) * link.X_RV.p;
  }
  for (LoopSpec& loop : spec.loops) {
    const int a = loop.link_a.empty() ? -1 : m.find_link(loop.link_a), b = loop.link_b.empty() ? -1 : m.find_link(loop.link_b);
    // A loop end on the world scales like the link at the other end.
    const auto end_map = [&](int link, int other) {
      const double l = other < 0 ? 1 : scales[static_cast<std::size_t>(other)].along;
      return link < 0 ? Mat3::diagonal(l, l, l) : map_of(link);
    };
    if (loop.type == LoopType::gear) {
      const auto unit = [&](int link, int dof) {
        const Link& carrier = m.link(link);
        return is_displacement(carrier.joint.type, dof) ? (carrier.parent < 0 ? scales[static_cast<std::size_t>(link)].along
                                                                              : scales[static_cast<std::size_t>(carrier.parent)].along)
                                                        : 1.0;
      };
      double factor = unit(a, loop.dof_a);
      const double of_b = unit(b, loop.dof_b);
      for (double& c : loop.polynomial) {
        c *= factor;
        factor /= of_b;
      }
      continue;
    }
    loop.X_AJ.p = end_map(a, b) * loop.X_AJ.p;
    loop.X_BJ.p = end_map(b, a) * loop.X_BJ.p;
    loop.length *= scales[static_cast<std::size_t>(b >= 0 ? b : a)].along;
  }
  for (SkinBone& bone : spec.skin_bones) {
    const Mat3 A = map_of(m.find_link(bone.link));
    bone.A = A * bone.A;
    bone.p = A * bone.p;
  }
  if (had_prepared) out.report.push_back("The collision data precomputed for the meshes was dropped; it is recomputed on import.");
  Result<MechanismPtr> made = Mechanism::make(std::move(spec));
  if (!made) return fail(std::move(made.error()));
  out.mechanism = std::move(*made);
  return out;
}

Result<Edited> scale(const Mechanism& m, const ScaleOptions& options) {
  const std::string location = "mechanism " + m.name();
  if (!usable(options.length) || !std::isfinite(options.mass) || options.mass < 0)
    return fail(ErrorCode::range, location, "The length factor or the new mass is not finite and above 0.",
                "Use a length factor and a mass above 0.");
  if (options.mass > 0 && !(m.mass() > 0))
    return fail(ErrorCode::structure, location, "The mechanism has no mass to scale.", "Give its links masses first.");
  const double l = options.length;
  LinkScale one{.along = l, .across = l, .mass = l * l * l};
  if (options.mass > 0) {
    one.mass = options.mass / m.mass();
    if (options.stout) one.across = std::sqrt(one.mass / l);
  }
  return scale_links(m, std::vector<LinkScale>(static_cast<std::size_t>(m.link_count()), one));
}

}  // namespace ugoki
