// Computes mass properties of MJCF bodies.

#include <algorithm>
#include <cmath>

#include "ugoki/robot_formats/inertia_repair.h"
#include "ugoki/robot_formats/mjcf_build.h"
#include "ugoki/robot_formats/symmetric_eigen.h"

namespace ugoki::robot_formats {
namespace {

constexpr double min_volume = 1e-15;  // m^3; smaller bodies count as empty, because division by their volume would lose all digits

/// Inertia of a shape with density 1 kg/m^3, about its centre and along its axes.
Inertia unit_inertia(MjcfGeomType type, const Vec3& s) {
  switch (type) {
    case MjcfGeomType::sphere: return solid_inertia(Shape::sphere(s.x), 1);
    case MjcfGeomType::capsule: return solid_inertia(Shape::capsule(s.x, {0, 0, -s.y}, {0, 0, s.y}), 1);
    case MjcfGeomType::box: return solid_inertia(Shape::box(s), 1);
    case MjcfGeomType::cylinder: return solid_inertia(Shape::cylinder(s.x, s.y), 1);
    case MjcfGeomType::ellipsoid: return solid_inertia(Shape::ellipsoid(s), 1);
    default: return {};
  }
}

/// Returns the mesh of a geom. Null if it has no points: for an unknown mesh name, adds a problem; for a mesh file that was not found, sets
/// body.missing_mass, which is reported later, once for all bodies.
MjcfMeshAsset* mesh_for_inertia(MjcfBody& body, const MjcfGeom& geom) {
  MjcfMeshAsset* const mesh = body.source->mesh(geom.mesh);
  if (!mesh) {
    geom.element.problem(ErrorCode::unknown, "No mesh is named " + formats::in_quotes(geom.mesh) + ".",
                         "Correct the name, or add the mesh.");
    return nullptr;
  }
  if (mesh->absent.empty()) return mesh;
  body.missing_mass = &geom;
  return nullptr;
}

/// Returns the inertia of one geom in the body's frame. If it cannot be computed, adds a problem and returns std::nullopt.
std::optional<Inertia> geom_inertia(MjcfBody& body, const MjcfGeom& geom, const RobotOptions& options) {
  if (geom.mass.value_or(geom.density) == 0 || geom.type == MjcfGeomType::plane) return Inertia{};
  if (geom.type == MjcfGeomType::hfield || geom.type == MjcfGeomType::sdf || geom.shell) {
    geom.element.problem(ErrorCode::unsupported,
                         "The mass of the body " + formats::in_quotes(body.name) + " comes from a shape whose inertia cannot be computed.",
                         "Add an <inertial> to the body, or mass=\"0\" to the shape.");
    return std::nullopt;
  }
  Inertia unit;
  if (geom.type == MjcfGeomType::mesh) {
    if (options.meshes == Meshes::none) {
      geom.element.note("Meshes are left out, and their mass with them.");
      return Inertia{};
    }
    const MjcfMeshAsset* const mesh = mesh_for_inertia(body, geom);
    if (!mesh) return std::nullopt;
    unit = mesh_inertia(mesh->points, mesh->triangles, mesh->kind);
    if (unit.mass < min_volume && geom.density > 0) {
      geom.element.problem(ErrorCode::structure,
                           "The mesh " + formats::in_quotes(geom.mesh) + " encloses no volume, or its triangles face inwards.",
                           "Repair the mesh, or add an <inertial> to the body.");
      return std::nullopt;
    }
  } else {
    unit = unit_inertia(geom.type, geom.size);
  }
  if (unit.mass < min_volume && geom.mass) return Inertia{};
  const double density = geom.mass ? *geom.mass / unit.mass : geom.density;
  const Inertia at_density{unit.mass * density, unit.h * density, unit.I * density};
  return at_density.in_parent(geom.X_BG);
}

/// Fits a primitive to its mesh, as MuJoCo does: its size is computed from the inertia box (box with the mesh's moments of inertia).
void fit_to_mesh(MjcfBody& body, MjcfGeom& geom) {
  if (geom.mesh.empty() || geom.type == MjcfGeomType::mesh || geom.type == MjcfGeomType::sdf) return;
  const MjcfMeshAsset* const mesh = body.source->mesh(geom.mesh);
  const MjcfGeomType type = geom.type;
  geom.type = MjcfGeomType::mesh;
  if (!mesh || !mesh->absent.empty()) return;
  const Inertia unit = mesh_inertia(mesh->points, mesh->triangles, mesh->kind);
  if (unit.mass < min_volume) return;
  SymmetricEigen e = symmetric_eigen(unit.about_centre());
  // z is the axis with the smallest moment, along which the inertia box has its longest side.
  const int z = e.values.x <= e.values.y && e.values.x <= e.values.z ? 0 : e.values.y <= e.values.z ? 1 : 2;
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const Vec3 I{e.values[x], e.values[y], e.values[z]};
  const auto half = [&](double twice) { return std::sqrt(std::max(0.0, 1.5 * twice / unit.mass)); };
  const Vec3 box{half(I.y + I.z - I.x), half(I.x + I.z - I.y), half(I.x + I.y - I.z)};
  switch (type) {
    case MjcfGeomType::sphere: geom.size = {(box.x + box.y + box.z) / 3, 0, 0}; break;
    case MjcfGeomType::capsule: geom.size = {(box.x + box.y) / 2, std::max(0.0, box.z - (box.x + box.y) / 4), 0}; break;
    case MjcfGeomType::cylinder: geom.size = {(box.x + box.y) / 2, box.z, 0}; break;
    default: geom.size = box;
  }
  geom.type = type;
  geom.mesh.clear();
  geom.X_BG = geom.X_BG * Pose{Mat3::columns(e.V.column(x), e.V.column(y), e.V.column(z)), unit.centre()};
}

Inertia explicit_inertia(const MjcfBody& body) {
  const MjcfAttributes a(body.inertial);
  for (const char* needed : {"pos", "mass"})
    if (!a.has(needed))
      body.inertial.problem(ErrorCode::syntax, "<inertial> has no " + std::string(needed) + ".",
                            "Add " + std::string(needed) + "=\"...\".");
  const double mass = a.number("mass", 0, not_negative);
  double full[6], diagonal[3] = {0, 0, 0};
  if (a.has("fullinertia") && a.has("diaginertia"))
    body.inertial.problem(ErrorCode::structure, "The inertia is given twice.", "Keep diaginertia or fullinertia.");
  const Vec3 centre = a.vec3("pos", {});
  if (a.numbers("fullinertia", full)) return Inertia::from_centre(mass, centre, {full[0], full[1], full[2], full[3], full[4], full[5]});
  (void)a.numbers("diaginertia", diagonal);
  return Inertia::from_centre(mass, centre, rotated(Sym3{diagonal[0], diagonal[1], diagonal[2], 0, 0, 0}, body.source->orientation(a)));
}

/// Applies the settings boundmass, boundinertia and balanceinertia, then repairs or refuses physically impossible moments.
void correct(Inertia& inertia, const MjcfBody& body, const RobotOptions& options) {
  const MjcfCompiler& c = body.source->compiler();
  const MjcfElement& source = body.inertial ? body.inertial : body.element;
  if (c.min_mass > inertia.mass || c.min_inertia > 0 || c.balance_inertia) {
    const double mass = std::max(inertia.mass, c.min_mass);
    SymmetricEigen e = symmetric_eigen(inertia.about_centre());
    Vec3& I = e.values;
    for (int i = 0; i < 3; ++i) I[i] = std::max(I[i], c.min_inertia);
    if (c.balance_inertia && (I.x + I.y < I.z || I.x + I.z < I.y || I.y + I.z < I.x)) {
      const double mean = (I.x + I.y + I.z) / 3;
      I = {mean, mean, mean};
      source.note("Physically impossible moments of inertia were replaced by their mean (balanceinertia).");
    }
    inertia = Inertia::from_centre(mass, inertia.centre(), symmetric_part(e.V * Mat3::diagonal(I.x, I.y, I.z) * e.V.transposed()));
  }
  if (!make_physical(inertia)) return;
  if (options.inertias == Inertias::strict)
    source.problem(ErrorCode::structure,
                   "The moments of inertia of the body " + formats::in_quotes(body.name) +
                       " are not physically possible (each must be positive and at most the sum of the other two).",
                   "Correct them, set balanceinertia, or allow the reader to repair them.");
  else
    source.note("Physically impossible moments of inertia were replaced by the nearest possible ones.");
}

}  // namespace

void fit_mjcf_geoms(MjcfBody& body) {
  for (MjcfGeom& geom : body.geoms) fit_to_mesh(body, geom);
}

Inertia mjcf_inertia(MjcfBody& body, const RobotOptions& options) {
  const MjcfCompiler& c = body.source->compiler();
  using FromGeoms = MjcfCompiler::FromGeoms;
  Inertia inertia;
  if (body.inertial && c.inertia_from_geoms != FromGeoms::always) {
    inertia = explicit_inertia(body);
  } else if (c.inertia_from_geoms != FromGeoms::never) {
    for (const MjcfGeom& geom : body.geoms) {
      if (geom.group < c.inertia_groups[0] || geom.group > c.inertia_groups[1]) continue;
      const std::optional<Inertia> of_geom = geom_inertia(body, geom, options);
      if (!of_geom) return inertia;  // stop: one problem for each body is enough
      inertia += *of_geom;
    }
  }
  correct(inertia, body, options);
  return inertia;
}

}  // namespace ugoki::robot_formats
