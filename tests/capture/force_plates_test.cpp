// Force plates of every type with known loads, directly and through a C3D file.
#include "ugoki/capture/force_plates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ugoki/formats/c3d.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::capture {
namespace {

constexpr double weight = 700;  // N

/// Load under one foot: the ground's force [N], its centre of pressure [m] and its free moment about the vertical [N m].
struct Load {
  Vec3 force, centre;
  double twist = 0;
};

/// Load at time t [s] of step 0 or 1. Steps last 0.6 s and overlap by 0.1 s, in which their vertical forces sum to the weight, as in
/// walking.
Load load_at(double t, int step) {
  const double on = 0.3 + 0.5 * step, off = on + 0.6, s = (t - on) / 0.6;
  Load l;
  l.centre = {0.1 + 0.7 * step + 0.2 * std::clamp(s, 0.0, 1.0), 0.2 + (step % 2 ? -0.05 : 0.05), 0};
  if (t < on || t > off) return l;
  const double in = std::min(1.0, (t - on) / 0.1), out = std::min(1.0, (off - t) / 0.1), share = std::min(in, out);
  l.force = {60 * std::sin(2 * pi * s) * share, 15 * share, weight * share};
  l.twist = 4 * std::sin(pi * s);
  return l;
}

struct PlateVariant {
  int type = 2;
  double heading = 0;          // rad, direction of the plate's x axis in the world
  bool measures_load = false;  // the channels contain the force on the plate instead of its reaction
  bool origin_up = false;      // the sensor's position has the opposite sign, as in files of some laboratories
  std::string moment_unit = "Nmm";
};

/// Synthetic recording of two plates whose z axes point down, as usual, with sensors 40 mm below the surface.
MarkerMotion recording(const PlateVariant& b) {
  MarkerMotion m;
  m.name = "steps";
  m.source = "steps.c3d";
  m.unit = 0.001;
  m.rate = 100;
  m.frames = 200;
  m.labels = {"LHEE", "LTOE", "RHEE", "RTOE"};
  m.analog_rate = 1000;
  std::vector<std::vector<double>> rows(2000);
  const double depth = 0.04, a = 0.12, s = 0.2;  // Kistler's sensors at (+-a, +-s)
  for (int p = 0; p < 2; ++p) {
    // Axes of the plate in the world: z points down, x in the direction of `heading`.
    const Vec3 x{std::cos(b.heading), std::sin(b.heading), 0}, z{0, 0, -1}, y = cross(z, x);
    const Mat3 R = Mat3::columns(x, y, z);
    const Vec3 middle{0.2 + 0.7 * p, 0.2, 0};
    ForcePlate plate;
    plate.type = b.type;
    const double half_x = 0.3, half_y = 0.25;
    const double signs[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    for (int c = 0; c < 4; ++c) plate.corners[c] = middle + R * Vec3{signs[c][0] * half_x, signs[c][1] * half_y, 0};
    plate.origin = b.type == 3 ? Vec3{a, s, -depth} : Vec3{0.002, -0.001, -depth};
    const Vec3 sensor = b.type == 3 ? Vec3{0, 0, depth} : Vec3{-0.002, 0.001, depth};  // relative to the middle of the surface
    if (b.origin_up) plate.origin = b.type == 3 ? Vec3{a, s, depth} : -plate.origin;
    const int count = b.type == 3 ? 8 : 6;
    for (int k = 0; k < count; ++k) {
      plate.channels.push_back(static_cast<int>(m.analog.size()));
      const bool force = b.type == 3 || k < 3;
      const std::string unit = b.type == 4 ? "V" : force ? "N" : b.type == 1 && k < 5 ? "mm" : b.moment_unit;
      m.analog.push_back({"P" + std::to_string(p) + "C" + std::to_string(k), unit, ""});
    }
    const double per_moment = b.moment_unit == "Nmm" ? 1000 : 1;
    if (b.type == 4) {
      // The channels are in volts; the matrix has a factor of 100 and cross-talk. Samples below are computed with its inverse.
      plate.calibration.assign(36, 0.0);
      for (std::size_t i = 0; i < 6; ++i) plate.calibration[7 * i] = 100;
      plate.calibration[6 * 1 + 0] = 3;  // cross-talk of fx into fy
    }
    for (int i = 0; i < 2000; ++i) {
      const Load l = load_at(i / 1000.0, p);
      const Vec3 F = transpose_times(R, l.force) * (b.measures_load ? -1.0 : 1.0);
      const Vec3 at = transpose_times(R, l.centre - middle);
      const Vec3 T = transpose_times(R, Vec3{0, 0, l.twist}) * (b.measures_load ? -1.0 : 1.0);
      std::vector<double> v;
      if (b.type == 1) {
        v = {F.x, F.y, F.z, 1000 * at.x, 1000 * at.y, per_moment * T.z};
      } else {
        const Vec3 M = cross(at - sensor, F) + T;  // moment about the sensor
        if (b.type == 3) {
          // Distribute force and moment over the four corner sensors: x and y forces from the moment about z, z forces from the others.
          const double fx34 = 0.5 * (F.x + 0.5 * M.z / s), fx12 = F.x - fx34, fy14 = 0.5 * (F.y + 0.5 * M.z / a), fy23 = F.y - fy14;
          const double u = M.x / s, w = -M.y / a;  // z1 + z2 - z3 - z4 and z1 + z4 - z2 - z3, where z1 ... z4 are vertical forces
          const double z1 = 0.25 * (F.z + u + w), z2 = 0.25 * (F.z + u - w), z3 = 0.25 * (F.z - u - w), z4 = 0.25 * (F.z - u + w);
          v = {fx12, fx34, fy14, fy23, z1, z2, z3, z4};
        } else {
          v = {F.x, F.y, F.z, per_moment * M.x, per_moment * M.y, per_moment * M.z};
          if (b.type == 4) {
            const double fx = F.x / 100;
            v = {fx, (F.y - 3 * fx) / 100, F.z / 100, 10 * M.x, 10 * M.y, 10 * M.z};  // moments in N mm, divided by 100
          }
        }
      }
      rows[static_cast<std::size_t>(i)].insert(rows[static_cast<std::size_t>(i)].end(), v.begin(), v.end());
    }
    m.plates.push_back(plate);
  }
  for (const std::vector<double>& row : rows) m.samples.insert(m.samples.end(), row.begin(), row.end());
  for (int f = 0; f < m.frames; ++f)
    for (int k = 0; k < 4; ++k) {  // heel and toe of the left foot on the first plate, of the right foot on the second
      m.positions.push_back({0.1 + 0.7 * (k / 2) + 0.24 * (k % 2), k < 2 ? 0.25 : 0.15, 0.03});
      m.residuals.push_back(0);
    }
  return m;
}

/// Compares the computed contact forces with load_at. @param force_error fraction of the weight @param position_error m
void check(const MarkerMotion& m, const std::string& what, double force_error = 1e-6, double position_error = 1e-9) {
  SCOPED_TRACE(what);
  ForcePlateOptions options;
  options.cutoff = 0;
  const auto made = calc_contact_forces(m, options);
  ASSERT_TRUE(made) << made.error().text();
  for (int f = 0; f < m.frames; ++f) {
    double sum = 0;
    for (int p = 0; p < 2; ++p) {
      const PlateForce& got = made->plates[static_cast<std::size_t>(p)][static_cast<std::size_t>(f)];
      Vec3 force, moment;
      double twist = 0;
      for (int i = 0; i < 10; ++i) {
        const Load l = load_at((10 * f + i) / 1000.0, p);
        force += l.force / 10;
        moment += cross(l.centre, l.force) / 10;
        twist += l.twist / 10;
      }
      sum += got.force.z;
      EXPECT_LT(norm(got.force - force), force_error * weight) << f;
      if (!got.loaded) continue;
      // Expected centre: the point at which the mean force gives the mean moment about the horizontal axes.
      const Vec3 centre{-moment.y / force.z, moment.x / force.z, 0};
      EXPECT_LT(norm(got.centre - centre), position_error) << f;
      const double couple = moment.z + twist - (centre.x * force.y - centre.y * force.x);
      EXPECT_NEAR(got.free_moment, couple, 100 * weight * position_error) << f;
    }
    const double t = (f + 0.5) / m.rate;
    if (t > 0.42 && t < 0.78) EXPECT_NEAR(sum, weight, 0.01 * weight);
  }
}

TEST(ForcePlates, EveryTypeReproducesTheLoad) {
  for (const int type : {1, 2, 3, 4})
    for (const double heading : {0.0, 1.5707963267948966, 2.4}) check(recording({type, heading}), "type " + std::to_string(type));
}

TEST(ForcePlates, SignAndUnitConventionsAreAccepted) {
  for (const int type : {1, 2, 3, 4}) {
    check(recording({type, 0.3, true}), "load instead of reaction, type " + std::to_string(type));
    check(recording({type, 0.3, false, true}), "sensor's position with the opposite sign, type " + std::to_string(type));
  }
  check(recording({2, 0.3, false, false, "Nm"}), "moments in N m");
}

TEST(ForcePlates, RoundTripThroughC3d) {
  for (const int type : {1, 2, 3, 4}) {
    const MarkerMotion m = recording({type, 0.3});
    const auto bytes = formats::write_c3d(m);
    ASSERT_TRUE(bytes);
    const auto again = formats::read_c3d(*bytes, "steps.c3d", {.up = formats::UpAxis::z});
    ASSERT_TRUE(again) << again.error().text();
    ASSERT_EQ(again->plates.size(), 2U);
    check(*again, "type " + std::to_string(type) + " read back", 1e-5, 1e-4);
  }
}

TEST(ForcePlates, OffsetOfTheEmptyPlateIsRemoved) {
  MarkerMotion m = recording({2, 0.3});
  for (std::size_t i = 0; i < m.samples.size(); i += m.analog.size()) {
    m.samples[i + 2] += 12;
    m.samples[i + 4] -= 900;
  }
  check(m, "offset", 1e-4, 1e-5);
}

TEST(ForcePlates, FilterKeepsTheImpulse) {
  MarkerMotion m = recording({2, 0.3});
  std::mt19937 random(11);
  std::normal_distribution<double> off(0, 5);
  for (double& x : m.samples) x += off(random);
  const auto made = calc_contact_forces(m).value();
  double impulse = 0, truth = 0, worst = 0;
  for (int f = 0; f < m.frames; ++f) {
    impulse += made.plates[0][static_cast<std::size_t>(f)].force.z;
    const double there = load_at((f + 0.45) / 100.0, 0).force.z;
    truth += there;
    if (f > 45 && f < 75) worst = std::max(worst, std::fabs(made.plates[0][static_cast<std::size_t>(f)].force.z - there));
  }
  EXPECT_NEAR(impulse / truth, 1, 0.005) << "seed 11";
  EXPECT_LT(worst, 0.03 * weight);
}

TEST(ForcePlates, StepsAreAssignedToFeet) {
  const MarkerMotion m = recording({2, 0});
  const ForceRecording forces = calc_contact_forces(m).value();
  std::vector<SolePoints> feet(2);
  for (int side = 0; side < 2; ++side) {
    feet[static_cast<std::size_t>(side)].count = 2;
    for (int f = 0; f < m.frames; ++f)
      for (int k = 0; k < 2; ++k) feet[static_cast<std::size_t>(side)].points.push_back(m.at(f, 2 * side + k));
  }
  const std::vector<PlateStep> steps = find_plate_steps(m, forces, feet);
  ASSERT_EQ(steps.size(), 2U);
  for (int k = 0; k < 2; ++k) {
    const PlateStep& s = steps[static_cast<std::size_t>(k)];
    EXPECT_EQ(s.plate, k);
    EXPECT_EQ(s.foot, k);
    EXPECT_LT(s.distance, 0.03);
    EXPECT_FALSE(s.shared);
    EXPECT_NEAR(s.first, 30 + 50 * k, 2);
    EXPECT_NEAR(s.last, 90 + 50 * k, 2);
  }
  // With both feet on the first plate, the step is marked as shared. With no foot near the plate, the step has no foot (-1).
  for (Vec3& p : feet[1].points) p.x -= 0.7;
  EXPECT_TRUE(find_plate_steps(m, forces, feet)[0].shared);
  for (SolePoints& foot : feet)
    for (Vec3& p : foot.points) p.y += 5;
  EXPECT_EQ(find_plate_steps(m, forces, feet)[0].foot, -1);
}

TEST(ForcePlates, InvalidPlatesAreRejected) {
  const auto refused = [](MarkerMotion m, const std::string& word) {
    const auto made = calc_contact_forces(m);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().text().find(word), std::string::npos) << made.error().text();
  };
  MarkerMotion m = recording({2, 0});
  m.plates[0].type = 7;
  refused(m, "type 7");
  m = recording({2, 0});
  m.plates[1].channels.pop_back();
  refused(m, "force plate 2");
  m = recording({4, 0});
  m.plates[0].calibration.clear();
  refused(m, "calibration");
  m = recording({2, 0});
  m.plates[0].corners[1] = m.plates[0].corners[0];
  refused(m, "area");
  m = recording({2, 0});
  m.samples[77] = NAN;
  refused(m, "finite");
  m.plates.clear();
  refused(m, "no force plates");
}

}  // namespace
}  // namespace ugoki::capture
