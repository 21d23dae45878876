// Operations on rotations, poses and joint values.

#include "ugoki/base/number.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::lsi {
namespace {

using circuit::input;
using circuit::InputPin;
using circuit::output;
using circuit::OutputPin;

constexpr PinTypeId scalar = PinTypeId::scalar, vector = PinTypeId::vector, rotation = PinTypeId::rotation, pose = PinTypeId::pose;

Vec3 vec_at(const double* x) { return {x[0], x[1], x[2]}; }
void put(const Vec3& v, double* to) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}
/// Returns the quaternion at x, normalised, because filtered or summed quaternions do not have length 1.
Quat quat_at(const double* x) { return normalized({x[0], x[1], x[2], x[3]}); }
void put(const Quat& q, double* to) {
  to[0] = q.w;
  to[1] = q.x;
  to[2] = q.y;
  to[3] = q.z;
}
struct PlacedPose {
  Vec3 p;
  Quat r;
};
PlacedPose pose_at(const double* x) { return {vec_at(x), quat_at(x + 3)}; }
void put(const PlacedPose& x, double* to) {
  put(x.p, to);
  put(x.r, to + 3);
}
PlacedPose compose(const PlacedPose& a, const PlacedPose& b) { return {a.p + rotate(a.r, b.p), normalized(a.r * b.r)}; }
PlacedPose inverse(const PlacedPose& x) { return {rotate(x.r.conjugate(), -1.0 * x.p), x.r.conjugate()}; }

circuit::LsiClass part(std::string name, std::string doc, std::vector<InputPin> inputs, std::vector<OutputPin> outputs,
                       circuit::StepFunction step) {
  circuit::LsiClass c;
  c.group = "rotations and poses";
  c.name = std::move(name);
  c.doc = std::move(doc);
  c.inputs = std::move(inputs);
  c.outputs = std::move(outputs);
  c.step = step;
  return c;
}
InputPin in(std::string name, PinTypeId type, std::string unit = {}, std::string doc = {}) {
  return input_pin(std::move(name), type, std::move(unit), std::move(doc));
}
OutputPin out(std::string name, PinTypeId type, std::string unit = {}, std::string doc = {}) {
  return output_pin(std::move(name), type, std::move(unit), std::move(doc));
}

constexpr const char* orders[] = {"ZYX", "ZXY", "YXZ", "YZX", "XYZ", "XZY"};
circuit::Parameter order_parameter() {
  circuit::Parameter p;
  p.name = "order";
  p.kind = circuit::ParameterKind::choice;
  p.choices.assign(std::begin(orders), std::end(orders));
  p.initial = std::string(orders[0]);
  p.doc = "Axes of the three angles in order. Each rotation is about the axis as rotated by the previous ones (intrinsic).";
  return p;
}
/// Returns the axes selected by the parameter `order`. Call::parameters contains the index of the selected value.
const char* order_of(const Call* c) { return orders[static_cast<std::size_t>(c->parameters[0])]; }

std::int32_t from_axis(const Call* c) {
  const Vec3 axis = vec_at(input(c, 0));
  const double length = norm(axis);
  if (!(length > 0)) return circuit::stop(c, "Its input 'axis' has length 0 and therefore no direction.");
  put(axis_angle((1 / length) * axis, *input(c, 1)), output(c, 0));
  return 0;
}

std::int32_t between(const Call* c) {
  const Vec3 a = vec_at(input(c, 0)), b = vec_at(input(c, 1));
  const double na = norm(a), nb = norm(b);
  if (!(na > 0) || !(nb > 0))
    return circuit::stop(c, std::string("Its input '") + (na > 0 ? "to" : "from") + "' has length 0 and therefore no direction.");
  put(rotation_between((1 / na) * a, (1 / nb) * b), output(c, 0));
  return 0;
}

void add_rotations(circuit::Library& library) {
  library.add(part("make rotation", "Rotation about an axis by an angle.",
                   {in("axis", vector, "", "Any length except 0."), in("angle", scalar, "rad", "")}, {out("out", rotation)}, from_axis));
  library.add(part("axis of rotation", "Rotation vector: the axis times the angle of the rotation, at most pi.", {in("in", rotation)},
                   {out("out", vector, "rad", "Direction: the axis; length: the angle.")}, [](const Call* c) -> std::int32_t {
                     put(log_map(quat_at(input(c, 0))), output(c, 0));
                     return 0;
                   }));
  circuit::LsiClass from = part("rotation from angles", "Rotation composed of three rotations about coordinate axes (Euler angles).",
                                {in("angles", vector, "rad", "Angles, in the order of the parameter `order`.")}, {out("out", rotation)},
                                [](const Call* c) -> std::int32_t {
                                  put(to_quat(from_euler(vec_at(input(c, 0)), order_of(c))), output(c, 0));
                                  return 0;
                                });
  from.parameters = {order_parameter()};
  library.add(std::move(from));
  circuit::LsiClass angles =
      part("angles of rotation", "Euler angles of a rotation; where they are not unique, the last one is 0.", {in("in", rotation)},
           {out("angles", vector, "rad", "Angles, in the order of the parameter `order`; the second one is from -pi/2 to pi/2.")},
           [](const Call* c) -> std::int32_t {
             put(to_euler(to_matrix(quat_at(input(c, 0))), order_of(c)), output(c, 0));
             return 0;
           });
  angles.parameters = {order_parameter()};
  library.add(std::move(angles));
  library.add(part("compose rotations", "Composition of two rotations: first b, then a.", {in("a", rotation), in("b", rotation)},
                   {out("out", rotation)}, [](const Call* c) -> std::int32_t {
                     put(normalized(quat_at(input(c, 0)) * quat_at(input(c, 1))), output(c, 0));
                     return 0;
                   }));
  library.add(part("invert rotation", "Inverse rotation.", {in("in", rotation)}, {out("out", rotation)}, [](const Call* c) -> std::int32_t {
    put(quat_at(input(c, 0)).conjugate(), output(c, 0));
    return 0;
  }));
  library.add(part("rotate vector", "Rotates a vector.", {in("rotation", rotation), in("in", vector)}, {out("out", vector)},
                   [](const Call* c) -> std::int32_t {
                     put(rotate(quat_at(input(c, 0)), vec_at(input(c, 1))), output(c, 0));
                     return 0;
                   }));
  library.add(part("blend rotations", "Interpolates along the shortest arc from a (share 0) to b (share 1).",
                   {in("a", rotation), in("b", rotation), in("share", scalar, "1", "Share of b, 0 to 1; other values extrapolate.")},
                   {out("out", rotation)}, [](const Call* c) -> std::int32_t {
                     put(normalized(slerp(quat_at(input(c, 0)), quat_at(input(c, 1)), *input(c, 2))), output(c, 0));
                     return 0;
                   }));
  library.add(part("rotation between", "Shortest rotation that turns one direction into another.", {in("from", vector), in("to", vector)},
                   {out("out", rotation)}, between));
}

void add_poses(circuit::Library& library) {
  library.add(part("make pose", "Pose from a position and a rotation.", {in("position", vector, "m"), in("rotation", rotation)},
                   {out("out", pose)}, [](const Call* c) -> std::int32_t {
                     put(PlacedPose{vec_at(input(c, 0)), quat_at(input(c, 1))}, output(c, 0));
                     return 0;
                   }));
  library.add(part("split pose", "Position and rotation of a pose.", {in("in", pose)},
                   {out("position", vector, "m"), out("rotation", rotation)}, [](const Call* c) -> std::int32_t {
                     const PlacedPose x = pose_at(input(c, 0));
                     put(x.p, output(c, 0));
                     put(x.r, output(c, 1));
                     return 0;
                   }));
  library.add(part("compose poses", "Composition of two poses: b is relative to a.", {in("a", pose), in("b", pose)}, {out("out", pose)},
                   [](const Call* c) -> std::int32_t {
                     put(compose(pose_at(input(c, 0)), pose_at(input(c, 1))), output(c, 0));
                     return 0;
                   }));
  library.add(part("invert pose", "Inverse pose: the pose of the world relative to the input.", {in("in", pose)}, {out("out", pose)},
                   [](const Call* c) -> std::int32_t {
                     put(inverse(pose_at(input(c, 0))), output(c, 0));
                     return 0;
                   }));
  library.add(part("transform point", "Transforms a point from the frame of the pose to the world.",
                   {in("pose", pose), in("point", vector, "m")}, {out("out", vector, "m")}, [](const Call* c) -> std::int32_t {
                     const PlacedPose x = pose_at(input(c, 0));
                     put(x.p + rotate(x.r, vec_at(input(c, 1))), output(c, 0));
                     return 0;
                   }));
  library.add(part("blend poses", "Interpolates from a (share 0) to b (share 1): positions linearly, rotations along the shortest arc.",
                   {in("a", pose), in("b", pose), in("share", scalar, "1", "Share of b, 0 to 1; other values extrapolate.")},
                   {out("out", pose)}, [](const Call* c) -> std::int32_t {
                     const PlacedPose a = pose_at(input(c, 0)), b = pose_at(input(c, 1));
                     const double t = *input(c, 2);
                     put(PlacedPose{a.p + t * (b.p - a.p), normalized(slerp(a.r, b.r, t))}, output(c, 0));
                     return 0;
                   }));
}

/// Adds the LSIs that read or replace one number of joint values.
void add_joint_values(circuit::Library& library) {
  circuit::Parameter index = number_parameter("index", 0, 0, 1e6, "", "Index of the number, counted from 0.");
  index.kind = circuit::ParameterKind::integer;
  const auto configure = [](Setup& s) {
    const circuit::Shape shape = s.in(0);
    if (shape.count != 0 && s.number("index") >= shape.count)
      s.fail(ErrorCode::range,
             "Its parameter 'index' is " + to_text(s.number("index")) + ", but its input has " + std::to_string(shape.count) + " numbers.",
             "Use an index from 0 to " + std::to_string(shape.count - 1) + ".");
    if (s.lsi_class().outputs[0].type == PinTypeId::joint_values) s.set_out(0, shape.count, shape.subject);
  };
  circuit::LsiClass get = part("joint value", "Reads one number of joint values.", {in("in", PinTypeId::joint_values)},
                               {out("out", scalar)}, [](const Call* c) -> std::int32_t {
                                 *output(c, 0) = input(c, 0)[static_cast<std::size_t>(c->parameters[0])];
                                 return 0;
                               });
  get.group = "joint values";
  get.parameters = {index};
  get.configure = configure;
  library.add(std::move(get));
  circuit::LsiClass set =
      part("set joint value", "Replaces one number of joint values.", {in("in", PinTypeId::joint_values), in("value", scalar)},
           {out("out", PinTypeId::joint_values)}, [](const Call* c) -> std::int32_t {
             std::memcpy(output(c, 0), input(c, 0), c->in_count[0] * sizeof(double));
             output(c, 0)[static_cast<std::size_t>(c->parameters[0])] = *input(c, 1);
             return 0;
           });
  set.group = "joint values";
  set.parameters = {index};
  set.configure = configure;
  library.add(std::move(set));
}

}  // namespace

void add_rotations_and_poses(circuit::Library& library) {
  add_rotations(library);
  add_poses(library);
  add_joint_values(library);
}

}  // namespace ugoki::lsi
