// Runs every builder that takes a skeleton or a mechanism on random skeletons. Each must end with a usable result or a located error.
// UGOKI_RANDOM_SEED and UGOKI_RANDOM_COUNT in the environment select other skeletons.

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "random_skeletons.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/intake/intake.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/mechanism_edit/combine.h"
#include "ugoki/mechanism_edit/cut.h"
#include "ugoki/mechanism_edit/edit.h"
#include "ugoki/mechanism_edit/growth.h"
#include "ugoki/mechanism_edit/mirror.h"
#include "ugoki/mechanism_edit/scale.h"
#include "ugoki/retarget/retarget.h"

namespace ugoki {
namespace {

constexpr unsigned time_limit = 300;  // s for one skeleton; most take milliseconds, so only an endless loop reaches it

char running[64] = "";  // text that print_seed() prints

/// Prints the seed of the running skeleton when the test program hangs or crashes.
extern "C" void print_seed(int signal) {
  std::size_t length = 0;
  while (running[length] != '\0') ++length;
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, running, length);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

std::uint64_t from_environment(const char* name, std::uint64_t usual) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : usual;
}

/// Calls `check(seed)` for a few hundred seeds under the time limit.
template <class Check>
void for_random_skeletons(Check check) {
  const std::uint64_t first = from_environment("UGOKI_RANDOM_SEED", 1), count = from_environment("UGOKI_RANDOM_COUNT", 300);
  std::signal(SIGALRM, print_seed);
  std::signal(SIGABRT, print_seed);
  std::signal(SIGSEGV, print_seed);
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    std::snprintf(running, sizeof running, "UGOKI_RANDOM_SEED=%llu\n", static_cast<unsigned long long>(seed));
    SCOPED_TRACE(running);
    ::alarm(time_limit);
    check(seed);
    ::alarm(0);
    if (::testing::Test::HasFatalFailure()) break;
  }
  std::signal(SIGALRM, SIG_DFL);
  std::signal(SIGABRT, SIG_DFL);
  std::signal(SIGSEGV, SIG_DFL);
}

void check_error(const Error& error) {
  EXPECT_FALSE(error.problems.empty());
  for (const Problem& p : error.problems) EXPECT_FALSE(p.message.empty()) << p.text();
}

/// Checks that all numbers of the mechanism are usable, and that the mechanism can be stored.
void check_mechanism(const Mechanism& m) {
  EXPECT_TRUE(std::isfinite(m.mass()) && m.mass() >= 0) << m.mass();
  for (const Link& l : m.links()) {
    EXPECT_TRUE(std::isfinite(l.inertia.mass) && l.inertia.mass >= 0) << l.name;
    EXPECT_TRUE(is_finite(l.inertia.h) && is_finite(l.joint.X_PJ.p)) << l.name;
    EXPECT_TRUE(std::isfinite(l.inertia.I.xx + l.inertia.I.yy + l.inertia.I.zz)) << l.name;
    for (const Shape& s : l.shapes) EXPECT_TRUE(is_finite(s.X_BS.p) && std::isfinite(s.radius) && std::isfinite(s.half_length)) << l.name;
  }
  const auto again = formats::read_mechanism(formats::write_mechanism(m), "again.json");
  EXPECT_TRUE(again) << again.error().text();
}

body::BodyOptions random_options(testing::RandomNumbers& random) {
  body::BodyOptions o;
  if (random.chance(0.2)) o.height = random.between(0.1, 3);
  if (random.chance(0.2)) o.mass = random.between(0.1, 300);
  o.sex = static_cast<body::Sex>(random.below(3));
  o.keep_unmoved = random.chance(0.3);
  o.level_floor = random.chance(0.8);
  return o;
}

/// The body of the seed's skeleton; null if it was refused.
MechanismPtr random_body(std::uint64_t seed) {
  const auto body = body::make_body(testing::random_skeleton(seed));
  return body ? body->mechanism : nullptr;
}

TEST(RandomSkeletons, BodiesAreUsableOrRefused) {
  int made = 0, human = 0;
  for_random_skeletons([&](std::uint64_t seed) {
    const MeasuredMotion measured = testing::random_skeleton(seed);
    testing::RandomNumbers random(~seed);
    const auto body = body::make_body(measured, random_options(random));
    if (!body) return check_error(body.error());
    ++made;
    human += body->human;
    check_mechanism(*body->mechanism);
    EXPECT_EQ(body->mechanism->link_count(), measured.joint_count());
    EXPECT_TRUE(std::isfinite(body->height) && std::isfinite(body->mass));
    const Motion motion = body::to_motion(*body, measured);
    if (motion.frames > 0) {
      const Error wrong = check_motion(motion, *body->mechanism);
      EXPECT_TRUE(wrong.empty()) << wrong.text();
    }
    EXPECT_TRUE(std::isfinite(body::calc_position_error(*body, measured, motion)));
  });
  std::printf("%d bodies, %d of them human\n", made, human);
  EXPECT_GT(made, 0);
}

TEST(RandomSkeletons, FilesAreTakenInOrRefused) {
  int taken = 0;
  for_random_skeletons([&](std::uint64_t seed) {
    const std::string bvh = formats::write_bvh(testing::random_skeleton(seed));
    testing::RandomNumbers random(~seed);
    intake::IntakeOptions options;
    if (random.chance(0.3)) options.unit = random.chance(0.5) ? 1 : 0.01;
    if (random.chance(0.2)) options.height = random.between(0.5, 2.5);
    const auto out = intake::take_in(bvh, "random.bvh", nullptr, options);
    if (!out) {
      check_error(out.error());
      for (const Problem& p : out.error().problems) EXPECT_TRUE(p.location.starts_with("random.bvh")) << p.text();
      return;
    }
    ++taken;
    check_mechanism(*out->mechanism);
    EXPECT_EQ(out->items.size(), 3u);
  });
  EXPECT_GT(taken, 0);
}

TEST(RandomSkeletons, MotionsAreRetargetedOrRefused) {
  int done = 0;
  for_random_skeletons([&](std::uint64_t seed) {
    const MechanismPtr to = random_body(~seed);
    const MeasuredMotion measured = testing::random_skeleton(seed);
    const auto from = body::make_body(measured);
    if (from)
      if (const auto anatomy = retarget::find_anatomy(*from->mechanism); !anatomy) check_error(anatomy.error());
    if (!from || !to) return;
    testing::RandomNumbers random(~seed);
    retarget::RetargetOptions options;
    options.keep_contacts = random.chance(0.7);
    options.balance = random.chance(0.3);
    options.slow_down = random.chance(0.3);
    const auto out = retarget::retarget(from->mechanism, body::to_motion(*from, measured), to, options);
    if (!out) return check_error(out.error());
    ++done;
    const Error wrong = check_motion(out->motion, *to);
    EXPECT_TRUE(wrong.empty()) << wrong.text();
  });
  std::printf("%d motions\n", done);
}

TEST(RandomSkeletons, MechanismsAreEditedOrRefused) {
  for_random_skeletons([&](std::uint64_t seed) {
    const MechanismPtr m = random_body(seed), other = random_body(seed + 1);
    if (!m || !other) return;
    testing::RandomNumbers random(~seed);
    const auto check = [](const auto& edited) {
      if (!edited) return check_error(edited.error());
      check_mechanism(*edited->mechanism);
    };
    const auto link = [&](const Mechanism& of) { return of.link(random.below(of.link_count())).name; };
    check(mirror(*m, {.normal = random.below(3), .swap_sides = random.chance(0.5)}));
    check(scale(*m, {.length = random.between(0.1, 10), .mass = random.chance(0.5) ? 0.0 : 50.0, .stout = random.chance(0.5)}));
    std::vector<LinkScale> scales;
    for (int i = 0; i < m->link_count(); ++i) scales.push_back({random.between(0.1, 3), random.between(0.1, 3), random.between(0.1, 3)});
    check(scale_links(*m, scales));
    check(grow(*m, {.age = random.between(2, 20)}));
    check(grow(*m, {.height = random.between(0.1, 3), .mass = random.between(1, 300)}));
    check(cut(*m, link(*m), {.keep = Keep::rest}));
    check(cut(*m, link(*m), {.keep = Keep::part, .base = random.chance(0.5) ? JointType::fixed : JointType::floating}));
    CombineOptions options;
    options.link_a = random.chance(0.2) ? "" : link(*m);
    options.link_b = link(*other);
    options.attachment = random.chance(0.5) ? Attachment::joint : Attachment::loop;
    check(combine(*m, *other, options));
    const Assignment assignments[] = {{link(*m), "inertia.mass", "2"}, {link(*m), "joint.damping", "0.5"}};
    check(edit(*m, assignments));
    check(edit(*m, std::vector<Assignment>{{link(*m), "inertia.density", "1000"}}));
  });
}

}  // namespace
}  // namespace ugoki
