// `ugoki mechanism`: combined, cut, mirrored, scaled, edited mechanisms; inertia of meshes; bodies of skeletons.

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "mechanism_output.h"
#include "output.h"
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

/// What all parts of the verb share.
struct Common {
  std::vector<std::string> inputs;
  std::string out;
  SourceOptions source;
  bool json = false;
};

/// A mechanism from a file (a measured file gives its body) or from an entry of the library.
Result<MechanismPtr> load_mechanism(const std::string& target, const SourceOptions& options) {
  const Result<TargetKind> kind = kind_of(target);
  if (!kind) return fail(kind.error());
  if (*kind == TargetKind::mechanism_file || *kind == TargetKind::measured_file) {
    Result<intake::Intake> taken = take_in_file(target, options);
    if (!taken) return fail(std::move(taken.error()));
    return taken->mechanism;
  }
  if (*kind != TargetKind::entry)
    return fail(ErrorCode::unsupported, target, "This is no mechanism.", "Give a mechanism's file or an entry of the library.");
  const Result<store::Library> library = library_of(target, options);
  if (!library) return fail(library.error());
  const Result<store::LibraryEntry> entry = library->resolve(target, "mechanism");
  if (!entry) return fail(entry.error());
  const Result<std::vector<std::byte>> data = library->data(entry->id);
  if (!data) return fail(data.error());
  return formats::read_mechanism({reinterpret_cast<const char*>(data->data()), data->size()}, "library entry " + entry->id);
}

/// Writes what an operation made, and says what it is.
int finish(const Common& common, const MechanismPtr& mechanism, std::vector<std::string> report) {
  const Result<MechanismPtr> prepared = geometry::prepare(mechanism);
  if (!prepared) return print_error(prepared.error(), common.json);
  std::erase_if(report,
                [](const std::string& line) { return line.starts_with("What collision analysis prepared"); });  // done again just now
  const Result<std::vector<std::string>> written = write_mechanism_file(**prepared, common.out);
  if (!written) return print_error(written.error(), common.json);
  report.insert(report.end(), written->begin(), written->end());
  const Mechanism& m = *mechanism;
  if (common.json) {
    print_json({{"file", common.out},
                {"name", m.name()},
                {"links", m.link_count()},
                {"freedoms", m.nv()},
                {"loops", m.loops().size()},
                {"mass_kg", m.mass()},
                {"report", report}});
    return 0;
  }
  print_line(common.out + ": " + m.name() + ", " + std::to_string(m.link_count()) + " links, " + std::to_string(m.nv()) + " freedoms, " +
             std::to_string(m.loops().size()) + " loops, " + to_fixed(m.mass(), 3) + " kg");
  for (const std::string& line : report) print_line(line);
  return 0;
}

int finish(const Common& common, Result<Edited> edited) {
  if (!edited) return print_error(edited.error(), common.json);
  return finish(common, edited->mechanism, std::move(edited->report));
}

/// Pose of three numbers and three angles (degrees, about x, then y, then z of the fixed axes).
Pose pose_of(const std::array<double, 3>& p, const std::array<double, 3>& degrees) {
  const double d = pi / 180;
  return {rotation_about({0, 0, 1}, degrees[2] * d) * rotation_about({0, 1, 0}, degrees[1] * d) * rotation_about({1, 0, 0}, degrees[0] * d),
          {p[0], p[1], p[2]}};
}

CLI::App* add_part(CLI::App& verb, const char* name, const char* what, const std::shared_ptr<Common>& common, int inputs, const char* of) {
  CLI::App* part = verb.add_subcommand(name, what);
  part->add_option("input", common->inputs, of)->required()->expected(inputs);
  part->add_option("-o,--out", common->out, "The file to write: .json, .urdf or .xml (MJCF)")->required();
  part->add_option("--library", common->source.library, "Library file (otherwise $UGOKI_LIBRARY or ~/.local/share/ugoki/library.db)");
  add_robot_options(*part, common->source.robot);
  part->add_flag("--json", common->json, "Print one JSON object");
  return part;
}

// --- combine

struct CombineChoice {
  Common common;
  CombineOptions options;
  std::array<double, 3> position{}, rotation{}, point{}, axis{0, 0, 1};
  std::string joint = "fixed", loop;
};

int run_combine(const CombineChoice& c) {
  const Result<MechanismPtr> a = load_mechanism(c.common.inputs[0], c.common.source),
                             b = load_mechanism(c.common.inputs[1], c.common.source);
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

void add_combine(CLI::App& verb, Action& action) {
  auto c = std::make_shared<CombineChoice>();
  const std::shared_ptr<Common> common(c, &c->common);
  CLI::App* part = add_part(verb, "combine", "Two mechanisms as one, joined at a link of each", common, 2, "The two mechanisms");
  part->add_option("--at", c->options.link_a, "Link of the first (otherwise the world)");
  part->add_option("--to", c->options.link_b, "Link of the second (otherwise its first)");
  part->add_option("--position", c->position, "Of the second's link in the first's, m")->delimiter(',');
  part->add_option("--rotation", c->rotation, "Of the second's link in the first's, degrees about x, then y, then z")->delimiter(',');
  part->add_option("--point", c->point, "Of the joint or loop in the second's link, m")->delimiter(',');
  part->add_option("--joint", c->joint, "Hang it on by a joint of this type")
      ->check(CLI::IsMember({"fixed", "revolute", "prismatic", "cylindrical", "planar", "universal", "spherical", "floating"}))
      ->capture_default_str();
  part->add_option("--loop", c->loop, "Both stay as they are and are held together by a loop of this type")
      ->check(CLI::IsMember({"weld", "ball", "revolute", "prismatic", "cylindrical", "planar", "universal", "distance"}));
  part->add_option("--axis", c->axis, "Of the joint or loop")->delimiter(',');
  part->add_option("--length", c->options.loop.length, "Of a distance loop, m");
  part->add_option("--prefix-first", c->options.prefix_a, "Before every name of the first");
  part->add_option("--prefix-second", c->options.prefix_b, "Before every name of the second (otherwise its name, where names are double)");
  part->add_option("--name", c->options.name, "Of the whole");
  part->footer(
      "Example:\n  ugoki mechanism combine horse.json rider.json --at back --to pelvis --position 0,0,0.25 --loop weld -o riding.json");
  part->callback([c, &action] { action = [c] { return run_combine(*c); }; });
}

// --- cut, mirror, scale, edit

void add_cut(CLI::App& verb, Action& action) {
  struct Choice {
    Common common;
    std::string at, keep = "rest", base = "floating";
  };
  auto c = std::make_shared<Choice>();
  CLI::App* part = add_part(verb, "cut", "Without a link and what hangs on it, or only these", {c, &c->common}, 1, "The mechanism");
  part->add_option("--at", c->at, "The link whose joint is cut")->required();
  part->add_option("--keep", c->keep, "The rest, or the part that is cut off")
      ->check(CLI::IsMember({"rest", "part"}))
      ->capture_default_str();
  part->add_option("--base-joint", c->base, "How the part is joined to the world")
      ->check(CLI::IsMember({"floating", "fixed"}))
      ->capture_default_str();
  part->footer("Example:\n  ugoki mechanism cut man.json --at abdomen --keep part -o trunk.json");
  part->callback([c, &action] {
    action = [c] {
      const Result<MechanismPtr> m = load_mechanism(c->common.inputs[0], c->common.source);
      if (!m) return print_error(m.error(), c->common.json);
      return finish(c->common, cut(**m, c->at, {.keep = c->keep == "part" ? Keep::part : Keep::rest, .base = *joint_type_named(c->base)}));
    };
  });
}

void add_mirror(CLI::App& verb, Action& action) {
  struct Choice {
    Common common;
    std::string axis = "y";
    bool keep_names = false;
  };
  auto c = std::make_shared<Choice>();
  CLI::App* part = add_part(verb, "mirror", "Its mirror image, left and right exchanged", {c, &c->common}, 1, "The mechanism");
  part->add_option("--across", c->axis, "The axis at a right angle to the mirror")
      ->check(CLI::IsMember({"x", "y", "z"}))
      ->capture_default_str();
  part->add_flag("--keep-names", c->keep_names, "Do not exchange left and right in names");
  part->footer("Example:\n  ugoki mechanism mirror left_arm.json -o right_arm.json");
  part->callback([c, &action] {
    action = [c] {
      const Result<MechanismPtr> m = load_mechanism(c->common.inputs[0], c->common.source);
      if (!m) return print_error(m.error(), c->common.json);
      return finish(c->common, mirror(**m, {.normal = c->axis[0] - 'x', .swap_sides = !c->keep_names}));
    };
  });
}

void add_scale(CLI::App& verb, Action& action) {
  struct Choice {
    Common common;
    GrowOptions grow;
    double factor = 0;
    std::string sex = "male";
  };
  auto c = std::make_shared<Choice>();
  CLI::App* part = add_part(verb, "scale", "Another size, mass or age", {c, &c->common}, 1, "The mechanism");
  CLI::Option* age = part->add_option("--age", c->grow.age, "Years, 2 to 20, of a human")->check(CLI::Range(2.0, 150.0));
  CLI::Option* height =
      part->add_option("--height", c->grow.height, "m (otherwise the median of the age)")->check(CLI::Range(1e-3, 1000.0));
  part->add_option("--mass", c->grow.mass, "kg (otherwise the median of the age, or with the cube of the height)")
      ->check(CLI::Range(1e-6, 1e9));
  part->add_option("--sex", c->sex, "For the medians")->check(CLI::IsMember({"male", "female"}))->capture_default_str();
  part->add_option("--from-age", c->grow.from_age, "Years of the body as it is")->capture_default_str();
  part->add_option("--from-height", c->grow.from_height, "m of the body as it is (otherwise that of its shapes)");
  part->add_option("--factor", c->factor, "Of all lengths")->check(CLI::Range(1e-6, 1e6))->excludes(age)->excludes(height);
  part->footer(
      "Example:\n  ugoki mechanism scale man.json --age 6 -o child.json\n  ugoki mechanism scale dog.json --height 1.2 --mass 60 -o "
      "mastiff.json");
  part->callback([c, &action] {
    if (c->factor <= 0 && c->grow.age <= 0 && c->grow.height <= 0 && c->grow.mass <= 0)
      throw CLI::ValidationError("scale", "give --age, --height, --mass or --factor.");
    action = [c] {
      const Result<MechanismPtr> m = load_mechanism(c->common.inputs[0], c->common.source);
      if (!m) return print_error(m.error(), c->common.json);
      c->grow.sex = c->sex == "female" ? GrowthSex::girl : GrowthSex::boy;
      return finish(c->common, c->factor > 0 ? scale(**m, {.length = c->factor, .mass = c->grow.mass}) : grow(**m, c->grow));
    };
  });
}

void add_edit(CLI::App& verb, Action& action) {
  struct Choice {
    Common common;
    std::vector<std::string> set;
  };
  auto c = std::make_shared<Choice>();
  CLI::App* part = add_part(verb, "edit", "Other limits, axes, springs, masses; validated", {c, &c->common}, 1, "The mechanism");
  part->add_option("--set", c->set, "LINK:FIELD=VALUE, as often as needed (docs/mechanisms.md lists the fields)")
      ->required()
      ->expected(1, -1);
  part->footer("Example:\n  ugoki mechanism edit man.json --set 'shank left:joint.upper=2.4' --set head:inertia.mass=6 -o edited.json");
  part->callback([c, &action] {
    action = [c] {
      const Result<MechanismPtr> m = load_mechanism(c->common.inputs[0], c->common.source);
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

void add_body(CLI::App& verb, Action& action) {
  struct Choice {
    Common common;
    std::string sex = "mean";
  };
  auto c = std::make_shared<Choice>();
  CLI::App* part =
      add_part(verb, "body", "A body of any skeleton: BVH, AMC, C3D, TRC, glTF, FBX, COLLADA", {c, &c->common}, 1, "The measured file");
  part->add_option("--height", c->common.source.intake.height, "Of the person, m (otherwise estimated)")->check(CLI::Range(0.1, 30.0));
  part->add_option("--mass", c->common.source.intake.mass, "Of the person, kg (otherwise estimated)")->check(CLI::Range(0.01, 100000.0));
  part->add_option("--asf", c->common.source.asf, "Skeleton of AMC files (otherwise NN.asf beside NN_MM.amc)");
  part->footer("Example:\n  ugoki mechanism body walk.bvh --mass 70 -o walker.json");
  part->callback([c, &action] {
    action = [c] {
      Result<intake::Intake> taken = take_in_file(c->common.inputs[0], c->common.source);
      if (!taken) return print_error(taken.error(), c->common.json);
      return finish(c->common, taken->mechanism, taken->report);
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
  if (c.hull) report.insert(report.begin(), "Of the convex hull.");
  if (!c.link.empty()) {
    const Result<MechanismPtr> m = load_mechanism(c.into, c.common.source);
    if (!m) return print_error(m.error(), c.json);
    MechanismSpec spec = (*m)->spec();
    const int at = (*m)->find_link(c.link);
    if (at < 0) return print_error(Error(ErrorCode::unknown, c.into, "It has no link " + c.link + ".", "Name one of its links."), c.json);
    spec.links[static_cast<std::size_t>(at)].inertia = i;
    const Result<MechanismPtr> made = Mechanism::make(std::move(spec));
    if (!made) return print_error(made.error(), c.json);
    const Result<std::vector<std::string>> written = write_mechanism_file(**made, c.out);
    if (!written) return print_error(written.error(), c.json);
    report.push_back("Given to " + c.link + " in " + c.out + ".");
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

void add_inertia(CLI::App& verb, Action& action) {
  auto c = std::make_shared<InertiaChoice>();
  CLI::App* part = verb.add_subcommand("inertia", "Mass, centre and moments of what a closed mesh encloses");
  part->add_option("mesh", c->mesh, "STL, OBJ or COLLADA")->required();
  CLI::Option* density = part->add_option("--density", c->options.density, "kg/m^3")->check(CLI::Range(1e-6, 1e6))->capture_default_str();
  part->add_option("--mass", c->options.mass, "kg, instead of a density")->check(CLI::Range(1e-9, 1e12))->excludes(density);
  part->add_option("--unit", c->unit, "m per unit of length of the file")->check(CLI::Range(1e-6, 1e3))->capture_default_str();
  part->add_flag("--hull", c->hull, "Of its convex hull (for meshes with holes)");
  CLI::Option* into = part->add_option("--mechanism", c->into, "A mechanism whose link gets this inertia");
  CLI::Option* link = part->add_option("--link", c->link, "Which of its links")->needs(into);
  CLI::Option* out = part->add_option("-o,--out", c->out, "The mechanism's new file: .json, .urdf or .xml")->needs(link);
  into->needs(link);
  link->needs(out);
  part->add_flag("--json", c->json, "Print one JSON object");
  part->footer("Example:\n  ugoki mechanism inertia skull.stl --unit 0.001 --mass 4.2");
  part->callback([c, &action] { action = [c] { return run_inertia(*c); }; });
}

}  // namespace

void add_mechanism_verb(CLI::App& app, Action& action) {
  CLI::App* verb = app.add_subcommand("mechanism", "Combine, cut, mirror, scale and edit mechanisms; find inertias; make bodies.");
  verb->require_subcommand(1);
  verb->footer("Inputs are files (mechanism JSON, URDF, SDF, MJCF; measured files give their body) or entries of the library.");
  add_combine(*verb, action);
  add_cut(*verb, action);
  add_mirror(*verb, action);
  add_scale(*verb, action);
  add_edit(*verb, action);
  add_inertia(*verb, action);
  add_body(*verb, action);
}

}  // namespace ugoki::cli
