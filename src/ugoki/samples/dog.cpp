// A shepherd dog: skeleton, masses and shapes. Dimensions follow the breed standard (FCI 166: 60 to 65 cm at the withers, body a tenth
// longer than high, depth of the chest almost half the height). Masses follow from the shapes at uniform density, except for the head
// and feet, which have given shares of the total of 32 kg. docs/design/samples.md compares them with published canine data.

#include <algorithm>
#include <string_view>

#include "ugoki/base/check.h"
#include "ugoki/samples/dog.h"
#include "ugoki/samples/samples.h"

namespace ugoki::samples {
namespace {

constexpr double dog_mass = 32;

/// Given shares of the body mass, for links whose density differs from the mean density. Fore foot (carpus and paw): 0.72 % (Jones,
/// Raschke, Riches 2018, PLoS ONE 13, German shepherds). Hind foot: a larger share, because the metatarsus is longer. Head: a larger share,
/// because of its bone.
constexpr struct {
  const char* label;
  double share;
} given_shares[] = {{"head", 0.050}, {"carpus", 0.0042}, {"paw fore", 0.0030}, {"hock", 0.0058}, {"paw hind", 0.0030}};

double share_of(std::string_view label) {
  for (const auto& g : given_shares)
    if (label.starts_with(g.label)) return g.share;
  return 0;
}

/// One link of the dog. Positions are world positions in the standing position.
struct Part {
  const char* name;
  const char* parent;
  const char* label;
  JointType joint;
  Vec3 at;                    ///< m, position of the joint
  std::vector<Shape> shapes;  ///< in the link's frame
  double damping, stiffness, effort;
  Vec3 lower, upper;  ///< deg, joint limits
};

/// Makes a shape visible only: it takes no part in collision detection.
Shape seen(Shape s) {
  s.collides = false;
  return s;
}

std::vector<Part> make_parts() {
  using enum JointType;
  const auto bar = [](double r, Vec3 a, Vec3 b) { return Shape::capsule(r, a, b); };
  std::vector<Part> p;
  const Vec3 root = dog_root, chest = dog_chest;
  p.push_back({"Pelvis",
               "",
               "pelvis",
               floating,
               root,
               {bar(0.080, {-0.055, 0.022, -0.03}, {0.05, 0.028, 0.0}), bar(0.080, {-0.055, -0.022, -0.03}, {0.05, -0.028, 0.0})},
               0,
               0,
               0,
               {},
               {}});
  p.push_back({"Loin",
               "Pelvis",
               "loin",
               spherical,
               {0.085, 0, 0.515},
               {bar(0.088, {0.0, 0.012, -0.018}, {0.13, 0.016, -0.030}), bar(0.088, {0.0, -0.012, -0.018}, {0.13, -0.016, -0.030})},
               4,
               120,
               250,
               {-15, -25, -25},
               {15, 25, 25}});
  p.push_back({"Chest",
               "Loin",
               "chest",
               spherical,
               chest,
               {bar(0.103, {0.015, 0.012, -0.045}, {0.235, 0.0, -0.055}), bar(0.103, {0.015, -0.012, -0.045}, {0.235, 0.0, -0.055}),
                bar(0.080, {0.05, 0, -0.095}, {0.27, 0, -0.095}), seen(bar(0.060, {0.10, 0.035, 0.015}, {0.25, 0.018, 0.035})),
                seen(bar(0.060, {0.10, -0.035, 0.015}, {0.25, -0.018, 0.035}))},
               4,
               120,
               250,
               {-15, -20, -20},
               {15, 20, 20}});
  p.push_back({"Neck",
               "Chest",
               "neck",
               spherical,
               dog_neck,
               {bar(0.072, {-0.03, 0, -0.03}, {0.062, 0, 0.062})},
               1.2,
               15,
               90,
               {-30, -50, -50},
               {30, 50, 50}});
  p.push_back({"Neck1",
               "Neck",
               "neck upper",
               spherical,
               dog_neck + Vec3{0.075, 0, 0.075},
               {bar(0.060, {0, 0, 0}, {0.055, 0, 0.060})},
               1.0,
               12,
               70,
               {-30, -50, -50},
               {30, 50, 50}});
  p.push_back({"Head",
               "Neck1",
               "head",
               spherical,
               dog_neck + Vec3{0.138, 0, 0.150},
               {bar(0.064, {0.005, 0, 0.008}, {0.045, 0, 0.004}), bar(0.037, {0.07, 0, -0.014}, {0.152, 0, -0.032}),
                seen(bar(0.026, {0.08, 0, -0.048}, {0.135, 0, -0.056})), seen(Shape::sphere(0.014, {Mat3::identity(), {0.184, 0, -0.026}})),
                seen(bar(0.016, {-0.012, 0.040, 0.045}, {-0.020, 0.056, 0.100})),
                seen(bar(0.016, {-0.012, -0.040, 0.045}, {-0.020, -0.056, 0.100})),
                seen(bar(0.008, {-0.020, 0.056, 0.105}, {-0.022, 0.060, 0.128})),
                seen(bar(0.008, {-0.020, -0.056, 0.105}, {-0.022, -0.060, 0.128}))},
               0.8,
               8,
               50,
               {-35, -50, -50},
               {35, 50, 50}});
  // The tail hangs down in a slight curve, as the breed standard describes ("sabre").
  Vec3 at = root + Vec3{-0.125, 0, -0.012}, step{-0.062, 0, -0.058};
  const char* tail[] = {"Tail", "Tail1", "Tail2", "Tail3"};
  for (int i = 0; i < 4; ++i) {
    p.push_back({tail[i],
                 i == 0 ? "Pelvis" : tail[i - 1],
                 i == 0 ? "tail" : "",
                 universal,
                 at,
                 {bar(0.027 - 0.0035 * i, {}, step)},
                 0.08,
                 0.8,
                 6,
                 {-45, -45, 0},
                 {45, 45, 0}});
    at += step;
    step = i == 0 ? Vec3{-0.040, 0, -0.078} : i == 1 ? Vec3{-0.036, 0, -0.082} : Vec3{-0.052, 0, -0.068};
  }
  for (const int side : {1, -1}) {
    const bool left = side > 0;
    const auto out = [&](const Vec3& v) { return Vec3{v.x, v.y * side, v.z}; };
    const DogLimb& f = dog_fore;
    const DogLimb& h = dog_hind;
    const double s = side;
    const auto name = [&](const char* l, const char* r) { return left ? l : r; };
    p.push_back({name("LeftScapula", "RightScapula"),
                 "Chest",
                 name("scapula left", "scapula right"),
                 revolute,
                 out(dog_scapula),
                 {bar(0.036, {0.005, 0, -0.02}, out(f.root - dog_scapula) * 0.9)},
                 2.5,
                 60,
                 160,
                 {-30, 0, 0},
                 {30, 0, 0}});
    p.push_back({name("LeftUpperArm", "RightUpperArm"),
                 name("LeftScapula", "RightScapula"),
                 name("upper arm left", "upper arm right"),
                 spherical,
                 out(f.root),
                 {bar(0.041, {}, out(f.middle - f.root) * 0.92)},
                 1.5,
                 4,
                 160,
                 {-25, -60, -25},
                 {25, 60, 25}});
    p.push_back({name("LeftForearm", "RightForearm"),
                 name("LeftUpperArm", "RightUpperArm"),
                 name("forearm left", "forearm right"),
                 revolute,
                 out(f.middle),
                 {bar(0.025, {}, out(f.end - f.middle)), seen(bar(0.031, {0.004, 0, 0.0}, out(f.end - f.middle) * 0.38))},
                 0.6,
                 1,
                 130,
                 {-120, 0, 0},
                 {60, 0, 0}});
    p.push_back({name("LeftCarpus", "RightCarpus"),
                 name("LeftForearm", "RightForearm"),
                 name("carpus left", "carpus right"),
                 revolute,
                 out(f.end),
                 {bar(0.020, {}, out(f.knuckle - f.end))},
                 0.3,
                 2,
                 80,
                 {-60, 0, 0},
                 {130, 0, 0}});
    p.push_back({name("LeftForePaw", "RightForePaw"),
                 name("LeftCarpus", "RightCarpus"),
                 name("paw fore left", "paw fore right"),
                 revolute,
                 out(f.knuckle),
                 {},
                 0.12,
                 2,
                 40,
                 {-110, 0, 0},
                 {80, 0, 0}});
    p.push_back({name("LeftThigh", "RightThigh"),
                 "Pelvis",
                 name("thigh left", "thigh right"),
                 spherical,
                 out(h.root),
                 {bar(0.058, {-0.005, 0, -0.01}, out(h.middle - h.root) * 0.85 + Vec3{-0.004, 0, 0}),
                  bar(0.040, out(h.middle - h.root) * 0.5, out(h.middle - h.root) * 0.97)},
                 2,
                 5,
                 200,
                 {-30, -60, -25},
                 {30, 60, 25}});
    p.push_back(
        {name("LeftShank", "RightShank"),
         name("LeftThigh", "RightThigh"),
         name("shank left", "shank right"),
         revolute,
         out(h.middle),
         {bar(0.027, {}, out(h.end - h.middle)), seen(bar(0.037, {-0.010, 0, -0.01}, out(h.end - h.middle) * 0.45 + Vec3{-0.004, 0, 0}))},
         1,
         1.5,
         170,
         {-60, 0, 0},
         {110, 0, 0}});
    p.push_back(
        {name("LeftHock", "RightHock"),
         name("LeftShank", "RightShank"),
         name("hock left", "hock right"),
         revolute,
         out(h.end),
         {bar(0.0185, {-0.010, 0, 0.018}, out(h.knuckle - h.end)), seen(Shape::sphere(0.021, {Mat3::identity(), {-0.010, 0, 0.010}}))},
         0.5,
         2,
         120,
         {-90, 0, 0},
         {80, 0, 0}});
    p.push_back({name("LeftHindPaw", "RightHindPaw"),
                 name("LeftHock", "RightHock"),
                 name("paw hind left", "paw hind right"),
                 revolute,
                 out(h.knuckle),
                 {},
                 0.12,
                 2,
                 40,
                 {-110, 0, 0},
                 {80, 0, 0}});
    for (std::size_t i : {p.size() - 5, p.size() - 1}) {
      // The paw: two colliding toe capsules, which touch the ground with their undersides; two more capsules for display.
      const double z = -p[i].at.z, r = 0.017, b = 0.019;
      p[i].shapes = {bar(r, {0.004, 0.014 * s, z + r}, {0.044, 0.015 * s, z + r}),
                     bar(r, {0.004, -0.014 * s, z + r}, {0.044, -0.015 * s, z + r}), seen(bar(b, {0, 0, 0}, {0.026, 0, z + b + 0.003})),
                     seen(bar(0.015, {0.01, 0, z + 0.018}, {0.052, 0, z + 0.0155}))};
    }
  }
  return p;
}

}  // namespace

MechanismPtr make_dog() {
  const std::vector<Part> parts = make_parts();
  MechanismSpec spec;
  spec.name = "Dog, shepherd";
  double sum = 0, given = 0;
  for (const Part& part : parts) {
    LinkSpec l;
    l.name = part.name;
    l.parent = part.parent;
    l.label = part.label;
    l.joint.type = part.joint;
    l.joint.axis = {0, 1, 0};
    if (part.joint == JointType::universal) l.joint.axis2 = {0, 0, 1};
    const auto parent = std::find_if(parts.begin(), parts.end(), [&](const Part& q) { return l.parent == q.name; });
    l.joint.X_PJ.p = parent == parts.end() ? part.at : part.at - parent->at;
    for (int k = 0; k < l.joint.nv() && part.joint != JointType::floating; ++k) {
      Dof& f = l.joint.dofs[static_cast<std::size_t>(k)];
      f.damping = part.damping;
      f.stiffness = part.stiffness;
      f.effort = part.effort;
      f.armature = part.effort < 90 ? 0.001 : 0;
      f.lower = part.lower[k] * (pi / 180);
      f.upper = part.upper[k] * (pi / 180);
    }
    for (Shape s : part.shapes) {
      s.friction = 1.0;
      l.shapes.push_back(s);
      if (s.collides || part.shapes.size() <= 2) l.inertia += solid_inertia(s, 1000);
    }
    (share_of(l.label) > 0 ? given : sum) += share_of(l.label) > 0 ? share_of(l.label) : l.inertia.mass;
    spec.links.push_back(std::move(l));
  }
  for (LinkSpec& l : spec.links) {
    const double share = share_of(l.label), scale = share > 0 ? share * dog_mass / l.inertia.mass : (1 - given) * dog_mass / sum;
    l.inertia = {l.inertia.mass * scale, l.inertia.h * scale, l.inertia.I * scale};
  }
  auto made = Mechanism::make(std::move(spec));
  UGOKI_CHECK(made.has_value());
  return *made;
}

}  // namespace ugoki::samples
