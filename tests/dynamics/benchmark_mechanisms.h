#pragma once
// Closed link systems with known solutions, built in code. Used by the tests and benchmarks of all methods for closed links.
//
// Planar systems move in the x-y plane (y is up) and rotate about z. Their bodies are three-dimensional, so each of their revolute
// loops has three redundant rows. A bar extends from its joint along its own x axis.

#include <cmath>
#include <string>
#include <vector>

#include "ugoki/mechanism/state.h"

namespace ugoki::testing {

/// A mechanism with an initial state in which its loops are closed.
struct ClosedCase {
  MechanismPtr mechanism;
  std::vector<double> q, v;
  Vec3 gravity;
};

inline constexpr Vec3 gravity_y{0, -9.81, 0};

/// A uniform thin bar along x, from x = 0 to x = `length`.
inline Inertia bar_inertia(double mass, double length) {
  const double I = mass * length * length / 12;
  return Inertia::from_centre(mass, {length / 2, 0, 0}, {0, I, I, 0, 0, 0});
}

/// A body with its centre of mass at (x, y) and moment of inertia I about the z axis through the centre of mass.
inline Inertia planar_inertia(double mass, double x, double y, double I) {
  return Inertia::from_centre(mass, {x, y, 0}, {I / 2, I / 2, I, 0, 0, 0});
}

/// A link with a revolute joint about z at the point (x, y) of its parent.
inline LinkSpec hinged(std::string name, std::string parent, double x, double y, const Inertia& inertia) {
  LinkSpec l;
  l.name = std::move(name);
  l.parent = std::move(parent);
  l.joint.type = JointType::revolute;
  l.joint.X_PJ.p = {x, y, 0};
  l.inertia = inertia;
  return l;
}

/// A pin about z that joins the point a of link_a and the point b of link_b.
inline LoopSpec pin(std::string name, std::string link_a, const Vec3& a, std::string link_b, const Vec3& b,
                    LoopType type = LoopType::revolute) {
  LoopSpec l;
  l.name = std::move(name);
  l.type = type;
  l.link_a = std::move(link_a);
  l.X_AJ.p = a;
  l.link_b = std::move(link_b);
  l.X_BJ.p = b;
  return l;
}

inline ClosedCase closed_case(MechanismSpec spec, std::vector<double> q, std::vector<double> v, const Vec3& gravity) {
  return {Mechanism::make(std::move(spec)).value(), std::move(q), std::move(v), gravity};
}

/// Dimensions of a planar four-bar linkage.
struct FourBar {
  double crank = 0.3, coupler = 1.0, rocker = 0.8, ground = 0.9;   ///< m
  double crank_mass = 1.0, coupler_mass = 1.5, rocker_mass = 2.0;  ///< kg, uniform bars
};

/// Four-bar linkage: crank at the origin, coupler on the crank, rocker at (ground, 0). The loop joins the ends of coupler and rocker,
/// on the branch with the coupler above the ground. `angle` [rad] and `speed` [rad/s] are those of the crank; the values of coupler
/// and rocker follow from closed forms.
inline ClosedCase four_bar(const FourBar& f, double angle, double speed, const Vec3& gravity = gravity_y) {
  MechanismSpec spec;
  spec.name = "four-bar";
  spec.links = {hinged("crank", "", 0, 0, bar_inertia(f.crank_mass, f.crank)),
                hinged("coupler", "crank", f.crank, 0, bar_inertia(f.coupler_mass, f.coupler)),
                hinged("rocker", "", f.ground, 0, bar_inertia(f.rocker_mass, f.rocker))};
  spec.loops = {pin("pin", "coupler", {f.coupler, 0, 0}, "rocker", {f.rocker, 0, 0})};
  // The pin is an intersection of two circles: about the crank's end, and about the rocker's joint
  const double x = f.crank * std::cos(angle), y = f.crank * std::sin(angle);
  const double dx = f.ground - x, dy = -y, d = std::sqrt(dx * dx + dy * dy);
  const double along = (f.coupler * f.coupler - f.rocker * f.rocker + d * d) / (2 * d);
  const double across = std::sqrt(f.coupler * f.coupler - along * along);
  const double px = x + (along * dx - across * dy) / d, py = y + (along * dy + across * dx) / d;
  const double coupler = std::atan2(py - y, px - x), rocker = std::atan2(py, px - f.ground);
  // Velocities: the end of the coupler moves with the end of the rocker
  const double s = std::sin(coupler - rocker);
  const double coupler_speed = f.crank * speed * std::sin(rocker - angle) / (f.coupler * s);
  const double rocker_speed = f.crank * speed * std::sin(coupler - angle) / (f.rocker * s);
  return closed_case(std::move(spec), {angle, coupler - angle, rocker}, {speed, coupler_speed - speed, rocker_speed}, gravity);
}

/// IFToMM benchmark A02 (Bayo & Avello 1994; Gonzalez et al. 2006): a ladder of N parallelograms, 2 N + 1 bars of 1 m and 1 kg,
/// upright at the start with 1 m/s at the top. Horizontal configurations are change points with N additional instantaneous DOFs.
inline ClosedCase n_four_bar(int n) {
  MechanismSpec spec;
  spec.name = std::to_string(n) + "-four-bar";
  std::vector<double> q, v;
  const auto upright = [](int k) { return "upright" + std::to_string(k); };
  for (int k = 0; k <= n; ++k) {
    spec.links.push_back(hinged(upright(k), "", k, 0, bar_inertia(1, 1)));
    q.push_back(pi / 2);
    v.push_back(-1);
    if (k == n) break;
    spec.links.push_back(hinged("top" + std::to_string(k), upright(k), 1, 0, bar_inertia(1, 1)));
    q.push_back(-pi / 2);
    v.push_back(1);
    spec.loops.push_back(pin("pin" + std::to_string(k), upright(k + 1), {1, 0, 0}, "top" + std::to_string(k), {1, 0, 0}));
  }
  return closed_case(std::move(spec), std::move(q), std::move(v), gravity_y);
}

/// N four-bar linkages in series, a swinging chain with N DOFs and N loops: the coupler of one linkage is the ground of the next.
inline ClosedCase four_bars_in_series(int n) {
  MechanismSpec spec;
  spec.name = std::to_string(n) + " four-bars in series";
  const FourBar f{.crank = 0.1, .coupler = 0.22, .rocker = 0.12, .ground = 0.2, .crank_mass = 0.1, .coupler_mass = 0.3, .rocker_mass = 0.1};
  const ClosedCase one = four_bar(f, -1.3, 0, {});
  std::vector<double> q, v;
  std::string ground;
  for (int k = 0; k < n; ++k) {
    const std::string i = std::to_string(k);
    // The joints of the next four-bar are on the coupler of this one
    LinkSpec crank = hinged("crank" + i, ground, 0, 0, bar_inertia(f.crank_mass, f.crank));
    LinkSpec coupler = hinged("coupler" + i, "crank" + i, f.crank, 0, bar_inertia(f.coupler_mass, f.coupler));
    LinkSpec rocker = hinged("rocker" + i, ground, f.ground, 0, bar_inertia(f.rocker_mass, f.rocker));
    spec.links.insert(spec.links.end(), {crank, coupler, rocker});
    spec.loops.push_back(pin("pin" + i, "coupler" + i, {f.coupler, 0, 0}, "rocker" + i, {f.rocker, 0, 0}));
    q.insert(q.end(), one.q.begin(), one.q.end());
    v.insert(v.end(), 3, 0.0);
    ground = "coupler" + i;
  }
  return closed_case(std::move(spec), std::move(q), std::move(v), gravity_y);
}

/// Slider-crank: crank at the origin, rod on the crank, a slider along x. The loop is the pin between rod and slider.
/// If crank and rod have equal lengths, angle = pi / 2 is a change point: the slider is on the crank's axis.
inline ClosedCase slider_crank(double crank, double rod, double angle, double speed, const Vec3& gravity = gravity_y) {
  MechanismSpec spec;
  spec.name = "slider-crank";
  LinkSpec slider = hinged("slider", "", 0, 0, planar_inertia(0.7, 0, 0, 0.01));
  slider.joint.type = JointType::prismatic;
  slider.joint.axis = {1, 0, 0};
  spec.links = {hinged("crank", "", 0, 0, bar_inertia(1, crank)), hinged("rod", "crank", crank, 0, bar_inertia(0.8, rod)), slider};
  spec.loops = {pin("pin", "slider", {}, "rod", {rod, 0, 0})};
  const double s = std::asin(crank * std::sin(angle) / rod);  // angle between the rod and the x axis, below the axis
  const double s_speed = crank * std::cos(angle) * speed / (rod * std::cos(s));
  const double x = crank * std::cos(angle) + rod * std::cos(s);
  const double x_speed = -crank * std::sin(angle) * speed - rod * std::sin(s) * s_speed;
  return closed_case(std::move(spec), {angle, -s - angle, x}, {speed, -s_speed - speed, x_speed}, gravity);
}

/// Constants and forces of Andrews' squeezing mechanism: 7 bodies, 1 DOF (Schiehlen 1990, Multibody Systems Handbook; IVP test set).
/// The order of v is beta, Theta, gamma, delta, phi, epsilon, Omega. SI units.
struct Andrews {
  static constexpr double xa = -.06934, ya = -.00227, xb = -.03635, yb = .03273, xc = .014, yc = .072;
  static constexpr double c0 = 4530, l0 = .07785, drive = .033;
  static constexpr double d = .028, da = .0115, e = .02, ea = .01421, rr = .007, ra = .00092, ss = .035, sa = .01874, sb = .01043,
                          sc = .018, sd = .02, ta = .02308, tb = .00916, u = .04, ua = .01228, ub = .00449, zf = .02, zt = .04, fa = .01421;

  /// Joint forces: the drive at beta and the spring between body 3 and the ground.
  static void forces(const std::vector<double>& q, std::vector<double>& tau) {
    for (double& t : tau) t = 0;
    tau[0] = drive;
    const double sg = std::sin(q[2]), cg = std::cos(q[2]);
    const double x = xb + sd * cg + sc * sg - xc, y = yb + sd * sg - sc * cg - yc, length = std::sqrt(x * x + y * y);
    const double f = -c0 * (length - l0) / length;
    tau[2] = f * x * (sc * cg - sd * sg) + f * y * (sd * cg + sc * sg);
  }
  static double spring_energy(const std::vector<double>& q) {
    const double sg = std::sin(q[2]), cg = std::cos(q[2]);
    const double x = xb + sd * cg + sc * sg - xc, y = yb + sd * sg - sc * cg - yc;
    return 0.5 * c0 * std::pow(std::sqrt(x * x + y * y) - l0, 2);
  }
};

inline ClosedCase andrews(LoopType type = LoopType::revolute) {
  using A = Andrews;
  MechanismSpec spec;
  spec.name = "Andrews' squeezing mechanism";
  spec.links = {hinged("k1", "", 0, 0, planar_inertia(.04325, A::ra, 0, 2.194e-6)),
                hinged("k2", "k1", A::rr, 0, planar_inertia(.00365, -A::da, 0, 4.410e-7)),
                hinged("k3", "", A::xb, A::yb, planar_inertia(.02373, A::sb, -A::sa, 5.255e-6)),
                hinged("k5", "", A::xa, A::ya, planar_inertia(.07050, A::ta, A::tb, 1.169e-5)),
                hinged("k4", "k5", A::zt, 0, planar_inertia(.00706, 0, -(A::e - A::ea), 5.667e-7)),
                hinged("k7", "", A::xa, A::ya, planar_inertia(.05498, A::ua, -A::ub, 1.912e-5)),
                hinged("k6", "k7", 0, -A::u, planar_inertia(.00706, A::zf - A::fa, 0, 5.667e-7))};
  spec.loops = {pin("k2 to k3", "k3", {0, -A::ss, 0}, "k2", {-A::d, 0, 0}, type),
                pin("k2 to k4", "k4", {0, -A::e, 0}, "k2", {-A::d, 0, 0}, type),
                pin("k2 to k6", "k6", {A::zf, 0, 0}, "k2", {-A::d, 0, 0}, type)};
  return closed_case(std::move(spec),
                     {-0.0617138900142764496358948458001, 0, 0.455279819163070380255912382449, 0.487364979543842550225598953530,
                      0.222668390165885884674473185609, 1.23054744454982119249735015568, -0.222668390165885884674473185609},
                     std::vector<double>(7, 0.0), {});
}

/// Bricard's mechanism (IFToMM benchmark A04): five bars of 1 m and 1 kg and the ground along six edges of a cube, six revolute joints.
/// Over-constrained: Gruebler's formula gives no DOF, but the mechanism has one.
inline ClosedCase bricard() {
  const Vec3 along[6] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  MechanismSpec spec;
  spec.name = "Bricard's mechanism";
  const double side = 0.1, I_along = side * side / 6, I_across = (1 + side * side) / 12;
  for (int i = 0; i < 5; ++i) {  // the ground is the sixth edge; at q = 0 the axes of all links are those of the world
    LinkSpec l;
    l.name = "bar" + std::to_string(i);
    l.parent = i == 0 ? "" : "bar" + std::to_string(i - 1);
    l.joint.type = JointType::revolute;
    l.joint.axis = cross(along[(i + 5) % 6], along[i]);
    l.joint.X_PJ.p = i == 0 ? Vec3{} : along[i - 1];
    const Vec3 a{std::fabs(along[i].x), std::fabs(along[i].y), std::fabs(along[i].z)};
    const Vec3 I = a * I_along + (Vec3{1, 1, 1} - a) * I_across;
    l.inertia = Inertia::from_centre(1, along[i] * 0.5, {I.x, I.y, I.z, 0, 0, 0});
    spec.links.push_back(std::move(l));
  }
  LoopSpec last;
  last.name = "last hinge";
  last.type = LoopType::revolute;
  last.X_AJ.p = -along[5];  // start of the edge of the ground; the origin is the end of this edge
  last.link_b = "bar4";
  last.X_BJ.p = along[4];
  last.axis = cross(along[4], along[5]);
  spec.loops = {last};
  return closed_case(std::move(spec), std::vector<double>(5, 0.0), std::vector<double>(5, 0.0), gravity_y);
}

/// Constants and forces of the stiff flyball governor (IFToMM benchmark A05): a shaft about z, a slider along the shaft, two rods with
/// balls, and two spring-dampers from the slider to the middles of the rods. The hinges of rods and springs are 5 cm from the axis (a
/// value deduced from the published curve). It is an open link system with forces. The order of v is shaft, slider, two rods; rod
/// angles are measured downwards from the horizontal.
struct Governor {
  static constexpr double stiffness = 8e5, damping = 4e4, rest = 0.5, top = 1.0, arm = 0.5, side = 0.05;

  /// Joint forces of the two spring-dampers.
  static void forces(const std::vector<double>& q, const std::vector<double>& v, std::vector<double>& tau) {
    for (double& t : tau) t = 0;
    for (std::size_t rod = 2; rod < 4; ++rod) {
      const double s = std::sin(q[rod]), c = std::cos(q[rod]);
      const double x = arm * c, z = top - arm * s - q[1];  // vector from the slider to the middle of the rod
      const double length = std::sqrt(x * x + z * z), x_rate = -arm * s, z_rate = -arm * c;
      const double along = (x * x_rate + z * z_rate) / length;  // d length / d angle
      const double rate = along * v[rod] - z / length * v[1];
      const double f = stiffness * (length - rest) + damping * rate;  // tension
      tau[rod] -= f * along;
      tau[1] += f * z / length;
    }
  }
};

inline ClosedCase governor() {
  MechanismSpec spec;
  spec.name = "flyball governor";
  const double rod_mass = 0.3, side = 0.01, across = side * side / 12;
  LinkSpec shaft;
  shaft.name = "shaft";
  shaft.joint.type = JointType::revolute;
  shaft.inertia = Inertia::from_centre(0.3, {0, 0, 0.5}, Sym3{1.0 / 12 + across, 1.0 / 12 + across, 2 * across, 0, 0, 0} * 0.3);
  LinkSpec slider;
  slider.name = "slider";
  slider.parent = "shaft";
  slider.joint.type = JointType::prismatic;
  slider.inertia = Inertia::from_centre(3, {}, Sym3{0.01, 0.01, 0.01, 0, 0, 0} * (3.0 / 6));
  spec.links = {shaft, slider};
  for (int k = 0; k < 2; ++k) {
    LinkSpec rod;
    rod.name = k == 0 ? "rod0" : "rod1";
    rod.parent = "shaft";
    rod.joint.type = JointType::revolute;
    rod.joint.X_PJ = {rotation_about({0, 0, 1}, k * pi), {k == 0 ? Governor::side : -Governor::side, 0, Governor::top}};
    rod.joint.axis = {0, 1, 0};  // a positive angle turns x towards -z
    rod.inertia = Inertia::from_centre(rod_mass, {0.5, 0, 0}, Sym3{2 * across, 1.0 / 12 + across, 1.0 / 12 + across, 0, 0, 0} * rod_mass);
    rod.inertia += Inertia::from_centre(5, {1, 0, 0}, {});
    spec.links.push_back(rod);
  }
  return closed_case(std::move(spec), {0, 0.5, pi / 6, pi / 6}, {2 * pi, 0, 0, 0}, {0, 0, -9.81});
}

}  // namespace ugoki::testing
