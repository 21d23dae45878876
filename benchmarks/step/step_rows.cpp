// The scenes of the table: limp and standing characters, heaps, a closed robot, a chain, a stack, many bodies.

#include <cstdio>
#include <functional>
#include <stdexcept>

#include "heap.h"
#include "run.h"
#include "ugoki/dynamics/loop_closure.h"

namespace ugoki::benchmarks {
namespace {

constexpr int second = 500;  // number of steps of 2 ms in 1 s

MechanismPtr made(MechanismSpec spec) {
  Result<MechanismPtr> m = Mechanism::make(std::move(spec));
  if (!m) throw std::runtime_error(m.error().text());
  return *m;
}

/// Pose of the base at which the lowest point of the mechanism is `height` m above the ground.
Pose above_ground(const Mechanism& m, const Quat& turn, double x, double y, double height) {
  State s(m);
  const Pose base{to_matrix(turn), {x, y, 0}};
  const Pose in_joint = m.link(0).joint.X_PJ.inverse() * base;
  const Quat q = to_quat(in_joint.R);
  const double values[7] = {in_joint.p.x, in_joint.p.y, in_joint.p.z, q.w, q.x, q.y, q.z};
  std::copy_n(values, 7, s.q.begin());
  return {base.R, {x, y, height - heights(m, s).first}};
}

/// Orientation of link 0 in the neutral position, rotated by the rotation vector r [rad].
Quat turned(const Mechanism& m, const Vec3& r) { return exp_map(r) * to_quat(m.link(0).joint.X_PJ.R); }

const std::string open_chain = "mechanism/open_chain/";

struct File {
  const char* row;
  std::string path;
  double friction;
  std::vector<std::string> without = {};
  bool own_text = true;  ///< true: MuJoCo reads the file's own text; false: text that we write from the model
};

bool is_missing(const File& f) {
  if (have_model(f.path)) return false;
  std::printf("  %s: skipped: %s is not in the shared data\n", f.row, f.path.c_str());
  return true;
}

void drop(Table& table, const File& f) {
  const std::string name = f.row;
  if ((!is_selected(name + ", falling") && !is_selected(name + ", lying")) || is_missing(f)) return;
  const StepModel model = read_model(f.path, f.friction, f.without);
  StepSource source;
  source.name = name;
  source.friction = f.friction;
  source.phases = {{name + ", falling", 3 * second}, {name + ", lying", second}};
  const Mechanism& m = *model.mechanisms.at(0);
  source.add(model.mechanisms.at(0), above_ground(m, turned(m, {0.25, 0.15, 0}), 0, 0, 0.2),
             f.own_text ? model.file_frames : std::map<std::string, Pose>{});
  if (f.own_text) finish_mjcf(source, model.mjcf);
  run_scene(table, source);
}

void humanoid(Table& table) { drop(table, {"humanoid of MuJoCo", open_chain + "mujoco/model__humanoid__humanoid.xml", 0.7}); }
const RowRegistration register_humanoid(100, humanoid);
void dm_humanoid(Table& table) { drop(table, {"humanoid of dm_control", open_chain + "dm_control/humanoid.xml", 0.7}); }
const RowRegistration register_dm_humanoid(110, dm_humanoid);
void cmu(Table& table) { drop(table, {"humanoid_CMU", open_chain + "dm_control/humanoid_CMU.xml", 0.7}); }
const RowRegistration register_cmu(120, cmu);
void quadruped(Table& table) { drop(table, {"quadruped of dm_control", open_chain + "dm_control/quadruped.xml", 1.0, {"ball"}}); }
const RowRegistration register_quadruped(130, quadruped);
void dog(Table& table) { drop(table, {"dog of dm_control", "animal/dog.xml", 0.9, {"ball"}, false}); }
const RowRegistration register_dog(140, dog);

void standing(Table& table) {
  const File f{"humanoid stands by servos", open_chain + "mujoco/model__humanoid__humanoid.xml", 0.7};
  if (!is_selected(f.row) || is_missing(f)) return;
  const StepModel model = read_model(f.path, f.friction);
  StepSource source;
  source.name = f.row;
  source.friction = f.friction;
  source.servo_gain = 2000;
  source.servo_damping = 60;
  source.stands = 0.95;
  source.phases = {{f.row, 2 * second}};
  const Mechanism& m = *model.mechanisms.at(0);
  source.add(model.mechanisms.at(0), above_ground(m, turned(m, {}), 0, 0, 0.002), model.file_frames);
  finish_mjcf(source, model.mjcf);
  run_scene(table, source);
}
const RowRegistration register_standing(200, standing);

void humanoid100(Table& table) {
  const File f{"humanoid100", open_chain + "mujoco/model__humanoid__humanoid100.xml", 1.0};
  if (!is_selected(f.row) || is_missing(f)) return;
  StepSource source;
  source.name = f.row;
  source.friction = f.friction;
  source.max_contacts = 1500;
  source.phases = {{f.row, 3 * second}};
  for (const MechanismPtr& m : read_model(f.path, f.friction).mechanisms) source.add(m, m->link(0).joint.X_PJ);
  run_scene(table, source);
}
const RowRegistration register_humanoid100(210, humanoid100);

void heap_of_humanoids(Table& table) {
  const File f{"ten humanoids in a heap", open_chain + "mujoco/model__humanoid__humanoid.xml", 0.7};
  if (!is_selected(f.row) || is_missing(f)) return;
  const StepModel model = read_model(f.path, f.friction);
  StepSource source;
  source.name = f.row;
  source.friction = f.friction;
  source.mjcf_geom = "solref=\".015 1\" solimp=\".9 .99 .003\"";  // the values of the MJCF file
  source.max_contacts = 2000;
  source.phases = {{f.row, 2 * second}};
  double top = 0;
  for (int i = 0; i < 10; ++i) {
    const Mechanism& m = *model.mechanisms.at(0);
    const Quat turn = turned(m, {1.4 + 0.02 * i, 0.1 * (i % 3), 0.6 * i});
    source.add(model.mechanisms.at(0), above_ground(m, turn, 0.15 * (i % 3 - 1), 0.15 * (i % 4 - 1.5), top + 0.02));
    top = heights(m, source.states.back()).second;
  }
  run_scene(table, source);
}
const RowRegistration register_heap_of_humanoids(220, heap_of_humanoids);

void cassie(Table& table) {
  const File f{"cassie, closed loops", "mechanism/closed_loop/cassie_sdf/cassie_v2.sdf", 0.8};
  if (!is_selected(f.row) || is_missing(f)) return;
  const StepModel model = read_model(f.path, f.friction);
  StepSource source;
  source.name = f.row;
  source.friction = f.friction;
  source.phases = {{f.row, 3 * second}};
  const Mechanism& m = *model.mechanisms.at(0);
  std::vector<double> q = m.neutral();
  for (const char* side : {"left", "right"}) {  // in the neutral position, two joints of each foot are beyond their limits
    const auto bend = [&](const char* link, double angle) {
      const Link& l = m.link(m.find_link(side + std::string(link)));
      q[static_cast<std::size_t>(l.q_index)] = angle;
    };
    bend("-foot-crank", -1.2);
    bend("-plantar-rod", 1.2);
    bend("-foot", -1.2);
  }
  dynamics::ClosedWorkspace closed(m);
  const dynamics::Closure closure = dynamics::close_positions(m, q, closed);
  if (closure.gap > 1e-6) throw std::runtime_error("cassie does not close");
  source.add(model.mechanisms.at(0), above_ground(m, turned(m, {0.25, 0.15, 0}), 0, 0, 0.2), {}, q);
  run_scene(table, source);
}
const RowRegistration register_cassie(230, cassie);

/// A free body of one shape.
MechanismPtr body_of(Shape shape, double density, double friction) {
  shape.friction = friction;
  MechanismSpec spec;
  spec.name = "body";
  LinkSpec link;
  link.name = "body";
  link.joint.type = JointType::floating;
  link.inertia = solid_inertia(shape, density);
  link.shapes.push_back(shape);
  spec.links.push_back(link);
  return made(std::move(spec));
}

void chain(Table& table) {
  const std::string row = "chain of 100 links";
  if (!is_selected(row)) return;
  constexpr int links = 100, root = 50;  // the base is in the middle, because MuJoCo's TinyXML refuses a depth of 100
  MechanismSpec spec;
  spec.name = "chain";
  for (int k = 0; k < links; ++k) {
    const int i = k <= links - 1 - root ? root + k : links - 1 - k;  // order of k: links 50 ... 99, then 49 ... 0
    LinkSpec link;
    link.name = "link " + std::to_string(i);
    const bool after = i > root, before = i < root;
    if (i == root) {
      link.joint.type = JointType::floating;
    } else {
      link.parent = "link " + std::to_string(after ? i - 1 : i + 1);
      link.joint.type = JointType::revolute;
      link.joint.axis = i % 2 == 0 ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
      link.joint.X_PJ.p = {after ? 0.1 : i == root - 1 ? 0.0 : -0.1, 0, 0};
      link.joint.dofs[0].damping = 0.01;
    }
    Shape shape = before ? Shape::capsule(0.03, {-0.1, 0, 0}, {0, 0, 0}) : Shape::capsule(0.03, {0, 0, 0}, {0.1, 0, 0});
    shape.friction = 0.8;
    link.inertia = solid_inertia(shape, 1000);
    link.shapes.push_back(shape);
    spec.links.push_back(link);
  }
  StepSource source;
  source.name = row;
  source.friction = 0.8;
  source.phases = {{row, 2 * second}};
  const MechanismPtr m = made(std::move(spec));
  source.add(m, above_ground(*m, exp_map({0, 0.1, 0}), 0, 0, 0.2));
  run_scene(table, source);
}
const RowRegistration register_chain(300, chain);

void stack(Table& table) {
  const std::string row = "ten boxes stacked";
  if (!is_selected(row)) return;
  StepSource source;
  source.name = row;
  source.friction = 0.8;
  source.phases = {{row, 2 * second}};
  const MechanismPtr box = body_of(Shape::box({0.1, 0.1, 0.1}), 500, 0.8);
  for (int i = 0; i < 10; ++i) source.add(box, {to_matrix(exp_map({0, 0, 0.1 * i})), {0, 0, 0.101 + 0.201 * i}});
  run_scene(table, source);
}
const RowRegistration register_stack(310, stack);

void mixed_bodies(Table& table) {
  const std::string row = "200 mixed bodies";
  if (!is_selected(row)) return;
  StepSource source;
  source.name = row;
  source.friction = heap_friction;
  source.max_contacts = 1500;
  source.rest_energy = 0.05;
  source.phases = {{row, 3 * second}};
  for (const HeapBody& b : make_heap(200)) {
    const double r = b.size[0], h = b.size[1];
    const Shape shape = b.shape == HeapShape::box       ? Shape::box({b.size[0], b.size[1], b.size[2]})
                        : b.shape == HeapShape::sphere  ? Shape::sphere(r)
                        : b.shape == HeapShape::capsule ? Shape::capsule(r, {0, 0, -h}, {0, 0, h})
                                                        : Shape::cylinder(r, h);
    const Quat turn{b.orientation[0], b.orientation[1], b.orientation[2], b.orientation[3]};
    source.add(body_of(shape, b.density, heap_friction), {to_matrix(turn), {b.position[0], b.position[1], b.position[2]}});
  }
  run_scene(table, source);
}
const RowRegistration register_mixed_bodies(320, mixed_bodies);

void spheres(Table& table) {
  const std::string row = "1000 spheres";
  if (!is_selected(row)) return;
  StepSource source;
  source.name = row;
  source.friction = 0.8;
  source.max_contacts = 1700;  // more need more memory than MuJoCo 2.2 can address
  source.rest_energy = 1;      // rest is not required: the bodies still fall at the end
  source.phases = {{row, second}};
  const MechanismPtr ball = body_of(Shape::sphere(0.05), 1000, 0.8);
  for (int i = 0; i < 1000; ++i) {
    const int layer = i / 100, k = i % 100;
    const double shift = layer % 2 == 0 ? 0.0 : 0.03;
    source.add(ball, {Mat3::identity(), {0.11 * (k % 10) - 0.5 + shift, 0.11 * (k / 10) - 0.5 + 0.7 * shift, 0.06 + 0.12 * layer}});
  }
  run_scene(table, source);
}
const RowRegistration register_spheres(330, spheres);

}  // namespace
}  // namespace ugoki::benchmarks
