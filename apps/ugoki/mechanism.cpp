// `ugoki mechanism`: combines, cuts, mirrors, scales and edits mechanisms; calculates inertias of meshes; makes bodies for skeletons.

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "mechanism_output.h"
#include "output.h"
#include "output_files.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/geometry/prepare.h"
#include "ugoki/mechanism_edit/combine.h"
#include "ugoki/mechanism_edit/cut.h"
#include "ugoki/mechanism_edit/edit.h"
#include "ugoki/mechanism_edit/growth.h"
#include "ugoki/mechanism_edit/mesh_inertia.h"
#include "ugoki/mechanism_edit/mirror.h"
#include "ugoki/mechanism_edit/scale.h"
#include "ugoki/robot_formats/mesh_file.h"
#include "ugoki/store/library.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

/// Options shared by the operations of the verb.
struct Common {
  std::vector<std::string> inputs;
  std::string out;
  SourceOptions source;
  bool json = false;
};

/// Loads a mechanism from a file or an entry of the library. For a measured file, the mechanism is the body made for the file's skeleton.
Result<MechanismPtr> load_mechanism(const std::string& target, const SourceOptions& options) {
  const Result<TargetKind> kind = kind_of(target);
  if (!kind) return fail(kind.error());
  if (*kind == TargetKind::mechanism_file || *kind == TargetKind::measured_file) {
    Result<intake::Intake> loaded = take_in_file(target, options);
    if (!loaded) return fail(std::move(loaded.error()));
    return loaded->mechanism;
  }
  if (*kind != TargetKind::entry)
    return fail(ErrorCode::unsupported, target, "This is not a mechanism.", "Name a mechanism file or an entry of the library.");
  const Result<store::Library> library = library_of(target, options);
  if (!library) return fail(library.error());
  const Result<store::LibraryEntry> entry = library->resolve(target, "mechanism");
  if (!entry) return fail(entry.error());
  const Result<std::vector<std::byte>> data = library->data(entry->id);
  if (!data) return fail(data.error());
  return formats::read_mechanism({reinterpret_cast<const char*>(data->data()), data->size()}, "library entry " + entry->id);
}

/// Loads input `index` (from 0). Before, refuses --out if it would overwrite an input, a project or a library.
Result<MechanismPtr> load_input(const Common& common, std::size_t index) {
  if (Result<void> may = check_outputs(input_files(common.inputs, common.source), {{"--out", common.out}}); !may)
    return fail(std::move(may.error()));
  return load_mechanism(common.inputs[index], common.source);
}

/// Writes the mechanism that an operation made and prints a summary. @return exit status
int finish(const Common& common, const MechanismPtr& mechanism, std::vector<std::string> report) {
  const Result<MechanismPtr> prepared = geometry::prepare(mechanism);
  if (!prepared) return print_error(prepared.error(), common.json);
  // prepare() has recomputed the collision data of the meshes, so the operation's note that they were dropped no longer applies.
  std::erase_if(report, [](const std::string& line) { return line.starts_with("The collision data precomputed"); });
  const Result<std::vector<std::string>> written = write_mechanism_file(**prepared, common.out);
  if (!written) return print_error(written.error(), common.json);
  report.insert(report.end(), written->begin(), written->end());
  const Mechanism& m = *mechanism;
  if (common.json) {
    print_json({{"file", common.out},
                {"name", m.name()},
                {"links", m.link_count()},
                {"dofs", m.nv()},
                {"loops", m.loops().size()},
                {"mass_kg", m.mass()},
                {"report", report}});
    return 0;
  }
  print_line(common.out + ": " + m.name() + ", " + std::to_string(m.link_count()) + " links, " + std::to_string(m.nv()) +
             " degrees of freedom, " + std::to_string(m.loops().size()) + " loops, " + to_fixed(m.mass(), 3) + " kg");
  for (const std::string& line : report) print_line(line);
  return 0;
}

int finish(const Common& common, Result<Edited> edited) {
  if (!edited) return print_error(edited.error(), common.json);
  return finish(common, edited->mechanism, std::move(edited->report));
}

/// Pose from a position [m] and three angles [degrees], applied about the fixed x, then y, then z axis.
Pose pose_of(const std::array<double, 3>& p, const std::array<double, 3>& degrees) {
  const double d = pi / 180;
  return {rotation_about({0, 0, 1}, degrees[2] * d) * rotation_about({0, 1, 0}, degrees[1] * d) * rotation_about({1, 0, 0}, degrees[0] * d),
          {p[0], p[1], p[2]}};
}

Verb add_operation(Verb verb, const char* name, const char* what, const std::shared_ptr<Common>& common, int inputs, const char* of) {
  Verb command = verb.add_subcommand(name, what);
  command.add_option("input", common->inputs, of).required().expected(inputs);
  command.add_option("-o,--out", common->out, "The file to write: .json, .urdf or .xml (MJCF)").required();
  add_library_option(command, common->source.library);
  add_robot_options(command, common->source.robot);
  command.add_flag("--json", common->json, "Print one JSON object");
  return command;
}

// --- combine

struct CombineChoice {
  Common common;
  CombineOptions options;
  std::array<double, 3> position{}, rotation{}, point{}, axis{0, 0, 1};
  std::string joint = "fixed", loop;
};

int run_combine(const CombineChoice& c) {
  const Result<MechanismPtr> a = load_input(c.common, 0), b = load_input(c.common, 1);
  if (!a) return print_error(a.error(), c.common.json);
  if (!b) return print_error(b.error(), c.common.json);
  if (norm(Vec3{c.axis[0], c.axis[1], c.axis[2]}) < 1e-9)
    return print_error(Error(ErrorCode::range, "--axis", "The axis has no direction.", "Give three numbers that are not all zero."),
                       c.common.json);
  CombineOptions options = c.options;
  if (options.link_b.empty()) options.link_b = (*b)->link(0).name;
  options.X_AB = pose_of(c.position, c.rotation);
  options.X_BJ.p = {c.point[0], c.point[1], c.point[2]};
  const Vec3 axis = normalized(Vec3{c.axis[0], c.axis[1], c.axis[2]});
  options.attachment = c.loop.empty() ? Attachment::joint : Attachment::loop;
  if (c.loop.empty()) {
    options.joint.type = *joint_type_named(c.joint);
    options.joint.axis = axis;
    options.joint.axis2 = any_perpendicular(axis);
  } else {
    options.loop.type = *loop_type_named(c.loop);
    options.loop.axis = axis;
    options.loop.axis2 = any_perpendicular(axis);
  }
  Result<Combined> made = combine(**a, **b, options);
  if (!made) return print_error(made.error(), c.common.json);
  return finish(c.common, made->mechanism, std::move(made->report));
}

void add_combine(Verb verb, Action& action) {
  auto c = std::make_shared<CombineChoice>();
  const std::shared_ptr<Common> common(c, &c->common);
  Verb command =
      add_operation(verb, "combine", "Combine two mechanisms into one, joined at a link of each", common, 2, "The two mechanisms");
  command.add_option("--at", c->options.link_a, "Link of the first mechanism (default: the world)");
  command.add_option("--to", c->options.link_b, "Link of the second mechanism (default: its first link)");
  command.add_option("--position", c->position, "Position of the second mechanism's link in the first one's, m").delimiter(',');
  command
      .add_option("--rotation", c->rotation, "Rotation of the second mechanism's link in the first one's, degrees about x, then y, then z")
      .delimiter(',');
  command.add_option("--point", c->point, "Position of the joint or loop in the second mechanism's link, m").delimiter(',');
  command.add_option("--joint", c->joint, "Attach the second mechanism by a joint of this type")
      .check(one_of({"fixed", "revolute", "prismatic", "cylindrical", "planar", "universal", "spherical", "floating"}))
      .capture_default_str();
  command.add_option("--loop", c->loop, "Keep both mechanisms as they are and connect them by a loop of this type")
      .check(one_of({"weld", "ball", "revolute", "prismatic", "cylindrical", "planar", "universal", "distance"}));
  command.add_option("--axis", c->axis, "Axis of the joint or loop").delimiter(',');
  command.add_option("--length", c->options.loop.length, "Length of a distance loop, m");
  command.add_option("--prefix-first", c->options.prefix_a, "Prefix of every name of the first mechanism");
  command.add_option("--prefix-second", c->options.prefix_b,
                     "Prefix of every name of the second mechanism (default: its name, if names would be duplicated)");
  command.add_option("--name", c->options.name, "Name of the result");
  command.footer(
      "Example:\n  ugoki mechanism combine horse.json rider.json --at back --to pelvis --position 0,0,0.25 --loop weld -o riding.json");
  command.callback([c, &action] { action = [c] { return run_combine(*c); }; });
}

// --- cut, mirror, scale, edit

void add_cut(Verb verb, Action& action) {
  struct Choice {
    Common common;
    std::string at, keep = "rest", base = "floating";
  };
  auto c = std::make_shared<Choice>();
  Verb command = add_operation(verb, "cut", "Remove a link with its descendants, or keep only these", {c, &c->common}, 1, "The mechanism");
  command.add_option("--at", c->at, "Link whose joint is cut").required();
  command.add_option("--keep", c->keep, "Which part to keep: the rest, or the part cut off")
      .check(one_of({"rest", "part"}))
      .capture_default_str();
  command.add_option("--base-joint", c->base, "Joint between the part cut off and the world")
      .check(one_of({"floating", "fixed"}))
      .capture_default_str();
  command.footer("Example:\n  ugoki mechanism cut man.json --at abdomen --keep part -o trunk.json");
  command.callback([c, &action] {
    action = [c] {
      const Result<MechanismPtr> m = load_input(c->common, 0);
      if (!m) return print_error(m.error(), c->common.json);
      return finish(c->common, cut(**m, c->at, {.keep = c->keep == "part" ? Keep::part : Keep::rest, .base = *joint_type_named(c->base)}));
    };
  });
}

void add_mirror(Verb verb, Action& action) {
  struct Choice {
    Common common;
    std::string axis = "y";
    bool keep_names = false;
  };
  auto c = std::make_shared<Choice>();
  Verb command = add_operation(verb, "mirror", "Mirror a mechanism; left and right are exchanged", {c, &c->common}, 1, "The mechanism");
  command.add_option("--across", c->axis, "Axis perpendicular to the mirror plane").check(one_of({"x", "y", "z"})).capture_default_str();
  command.add_flag("--keep-names", c->keep_names, "Do not exchange left and right in names");
  command.footer("Example:\n  ugoki mechanism mirror left_arm.json -o right_arm.json");
  command.callback([c, &action] {
    action = [c] {
      const Result<MechanismPtr> m = load_input(c->common, 0);
      if (!m) return print_error(m.error(), c->common.json);
      return finish(c->common, mirror(**m, {.normal = c->axis[0] - 'x', .swap_sides = !c->keep_names}));
    };
  });
}

void add_scale(Verb verb, Action& action) {
  struct Choice {
    Common common;
    GrowOptions grow;
    double factor = 0;
    std::string sex = "male";
  };
  auto c = std::make_shared<Choice>();
  Verb command = add_operation(verb, "scale", "Change size, mass or age", {c, &c->common}, 1, "The mechanism");
  const Option age = command.add_option("--age", c->grow.age, "Age of a human in years, 2 to 20").check(range(2.0, 150.0));
  const Option height =
      command.add_option("--height", c->grow.height, "Height in m (default: the median of the age)").check(number_from(1e-3, 1000.0));
  command.add_option("--mass", c->grow.mass, "Mass in kg (default: the median of the age, or proportional to the cube of the height)")
      .check(number_from(1e-6, 1e9));
  command.add_option("--sex", c->sex, "Sex whose medians are used").check(one_of({"male", "female"})).capture_default_str();
  command.add_option("--from-age", c->grow.from_age, "Age of the given body in years").capture_default_str();
  command.add_option("--from-height", c->grow.from_height, "Height of the given body in m (default: the height of its shapes)");
  command.add_option("--factor", c->factor, "Factor of all lengths").check(range(1e-6, 1e6)).excludes(age).excludes(height);
  command.footer(
      "Example:\n  ugoki mechanism scale man.json --age 6 -o child.json\n  ugoki mechanism scale dog.json --height 1.2 --mass 60 -o "
      "mastiff.json");
  command.callback([c, &action] {
    if (c->factor <= 0 && c->grow.age <= 0 && c->grow.height <= 0 && c->grow.mass <= 0)
      refuse("scale", "needs --age, --height, --mass or --factor.");
    action = [c] {
      const Result<MechanismPtr> m = load_input(c->common, 0);
      if (!m) return print_error(m.error(), c->common.json);
      c->grow.sex = c->sex == "female" ? GrowthSex::girl : GrowthSex::boy;
      return finish(c->common, c->factor > 0 ? scale(**m, {.length = c->factor, .mass = c->grow.mass}) : grow(**m, c->grow));
    };
  });
}

void add_edit(Verb verb, Action& action) {
  struct Choice {
    Common common;
    std::vector<std::string> set;
  };
  auto c = std::make_shared<Choice>();
  Verb command =
      add_operation(verb, "edit", "Change limits, axes, springs or masses; the result is validated", {c, &c->common}, 1, "The mechanism");
  command.add_option("--set", c->set, "LINK:FIELD=VALUE; may be repeated (docs/mechanisms.md lists the fields)").required().expected(1, -1);
  command.footer("Example:\n  ugoki mechanism edit man.json --set 'shank left:joint.upper=2.4' --set head:inertia.mass=6 -o edited.json");
  command.callback([c, &action] {
    action = [c] {
      const Result<MechanismPtr> m = load_input(c->common, 0);
      if (!m) return print_error(m.error(), c->common.json);
      std::vector<Assignment> list;
      Error errors;
      for (const std::string& text : c->set) {
        Result<Assignment> one = parse_assignment(text);
        if (one)
          list.push_back(std::move(*one));
        else
          errors.problems.insert(errors.problems.end(), one.error().problems.begin(), one.error().problems.end());
      }
      if (!errors.empty()) return print_error(errors, c->common.json);
      return finish(c->common, edit(**m, list));
    };
  });
}

// --- body

void add_body(Verb verb, Action& action) {
  struct Choice {
    Common common;
    std::string sex = "mean";
  };
  auto c = std::make_shared<Choice>();
  Verb command = add_operation(verb, "body", "Make a body for a skeleton from BVH, AMC, C3D, TRC, glTF, FBX, COLLADA", {c, &c->common}, 1,
                               "The measured file");
  add_person_options(command, c->common.source);
  add_skeleton_option(command, c->common.source);
  command.footer("Example:\n  ugoki mechanism body walk.bvh --mass 70 -o walker.json");
  command.callback([c, &action] {
    action = [c] {
      if (Result<void> may = check_outputs(input_files(c->common.inputs, c->common.source), {{"--out", c->common.out}}); !may)
        return print_error(may.error(), c->common.json);
      Result<intake::Intake> loaded = take_in_file(c->common.inputs[0], c->common.source);
      if (!loaded) return print_error(loaded.error(), c->common.json);
      return finish(c->common, loaded->mechanism, loaded->report);
    };
  });
}

// --- inertia

struct InertiaChoice {
  std::string mesh, into, link, out;
  MeshInertiaOptions options;
  double unit = 1;
  bool hull = false, json = false;
  Common common;
};

Json vector_json(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

int run_inertia(const InertiaChoice& c) {
  if (Result<void> may = check_outputs({{"the mesh", c.mesh}, {"--mechanism", c.into}}, {{"--out", c.out}}); !may)
    return print_error(may.error(), c.json);
  const Result<std::string> bytes = files::read_file(c.mesh);
  if (!bytes) return print_error(bytes.error(), c.json);
  const Result<robot_formats::MeshFile> file = robot_formats::read_mesh(*bytes, c.mesh);
  if (!file) return print_error(file.error(), c.json);
  std::vector<Vec3> points;
  for (const Vec3& p : file->points) points.push_back(p * c.unit);
  std::vector<Triangle> triangles;
  for (const auto& t : file->triangles) triangles.push_back({t[0], t[1], t[2]});
  if (c.hull) {
    const Result<GeometryPtr> hull = geometry::make_hull_geometry(points, c.mesh);
    if (!hull) return print_error(hull.error(), c.json);
    points = (*hull)->vertices;
    triangles = (*hull)->triangles;
  }
  const Result<MeshInertia> found = mesh_inertia(points, triangles, c.mesh, c.options);
  if (!found) return print_error(found.error(), c.json);
  const Inertia& i = found->inertia;
  const Sym3 I = i.about_centre();
  std::vector<std::string> report = found->report;
  if (c.hull) report.insert(report.begin(), "The values are those of the convex hull.");
  if (!c.link.empty()) {
    const Result<MechanismPtr> m = load_mechanism(c.into, c.common.source);
    if (!m) return print_error(m.error(), c.json);
    MechanismSpec spec = (*m)->spec();
    const int at = (*m)->find_link(c.link);
    if (at < 0)
      return print_error(Error(ErrorCode::unknown, c.into, "The mechanism has no link " + c.link + ".", "Name one of its links."), c.json);
    spec.links[static_cast<std::size_t>(at)].inertia = i;
    const Result<MechanismPtr> made = Mechanism::make(std::move(spec));
    if (!made) return print_error(made.error(), c.json);
    const Result<std::vector<std::string>> written = write_mechanism_file(**made, c.out);
    if (!written) return print_error(written.error(), c.json);
    report.push_back("The inertia of " + c.link + " in " + c.out + " was set to these values.");
  }
  if (c.json) {
    print_json({{"mass_kg", i.mass},
                {"density", found->density},
                {"volume_m3", found->volume},
                {"area_m2", found->area},
                {"centre_m", vector_json(i.centre())},
                {"about_centre", Json::array({I.xx, I.yy, I.zz, I.xy, I.xz, I.yz})},
                {"parts", found->parts},
                {"turned_triangles", found->turned},
                {"report", report}});
    return 0;
  }
  print_line("mass         " + to_text(i.mass) + " kg (density " + to_text(found->density) + " kg/m^3)");
  print_line("volume       " + to_text(found->volume) + " m^3, surface " + to_text(found->area) + " m^2");
  print_line("centre       " + to_text(i.centre().x) + ", " + to_text(i.centre().y) + ", " + to_text(i.centre().z) + " m");
  print_line("about centre xx " + to_text(I.xx) + ", yy " + to_text(I.yy) + ", zz " + to_text(I.zz) + ", xy " + to_text(I.xy) + ", xz " +
             to_text(I.xz) + ", yz " + to_text(I.yz) + " kg m^2");
  for (const std::string& line : report) print_line(line);
  return 0;
}

void add_inertia(Verb verb, Action& action) {
  auto c = std::make_shared<InertiaChoice>();
  Verb command =
      verb.add_subcommand("inertia", "Calculate mass, centre of mass and moments of inertia of the volume that a closed mesh encloses");
  command.add_option("mesh", c->mesh, "STL, OBJ or COLLADA").required();
  const Option density = command.add_option("--density", c->options.density, "kg/m^3").check(range(1e-6, 1e6)).capture_default_str();
  command.add_option("--mass", c->options.mass, "Mass in kg, instead of a density").check(range(1e-9, 1e12)).excludes(density);
  command.add_option("--unit", c->unit, "Metres per unit of length of the file").check(range(1e-6, 1e3)).capture_default_str();
  command.add_flag("--hull", c->hull, "Use the convex hull (for meshes with holes)");
  const Option into = command.add_option("--mechanism", c->into, "Mechanism in which a link is given this inertia");
  const Option link = command.add_option("--link", c->link, "Link of that mechanism").needs(into);
  const Option out = command.add_option("-o,--out", c->out, "File for the changed mechanism: .json, .urdf or .xml").needs(link);
  into.needs(link);
  link.needs(out);
  command.add_flag("--json", c->json, "Print one JSON object");
  command.footer("Example:\n  ugoki mechanism inertia skull.stl --unit 0.001 --mass 4.2");
  command.callback([c, &action] { action = [c] { return run_inertia(*c); }; });
}

}  // namespace

void add_mechanism_verb(Verb app, Action& action) {
  Verb verb = app.add_subcommand("mechanism", "Combine, cut, mirror, scale and edit mechanisms; calculate inertias; make bodies.");
  verb.require_subcommand(1);
  verb.footer(
      "Inputs are entries of the library or files: mechanism JSON, URDF, SDF, MJCF, or a measured file, for whose skeleton a body is "
      "made.");
  add_combine(verb, action);
  add_cut(verb, action);
  add_mirror(verb, action);
  add_scale(verb, action);
  add_edit(verb, action);
  add_inertia(verb, action);
  add_body(verb, action);
}

}  // namespace ugoki::cli
