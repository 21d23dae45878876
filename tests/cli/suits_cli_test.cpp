// `ugoki info`, `convert`, `import` and `run` on recordings of suits (MVNX) and on SMPL motions (.npz).
#include <zlib.h>

#include "cli_fixture.h"
#include "ugoki/base/number.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {
namespace {

using SuitsCliTest = CliTest;

std::string text_of(const Vec3& v) { return to_text(v.x) + " " + to_text(v.y) + " " + to_text(v.z) + " "; }
std::string text_of(const Quat& q) { return to_text(q.w) + " " + text_of(Vec3{q.x, q.y, q.z}); }

/// A motion as an MVNX file, from its world poses.
std::string mvnx(const MeasuredMotion& m) {
  std::string segments, joints, frames;
  for (const SkeletonJoint& j : m.skeleton.joints) {
    segments += "<segment label=\"" + j.name + "\">";
    for (const Vec3& end : j.end_sites) segments += "<points><point label=\"end\"><pos_b>" + text_of(end) + "</pos_b></point></points>";
    segments += "</segment>";
    if (j.parent >= 0)
      joints += "<joint><connector1>" + m.skeleton.joints[static_cast<std::size_t>(j.parent)].name + "/a</connector1><connector2>" +
                j.name + "/b</connector2></joint>";
  }
  std::vector<Pose> X;
  for (int f = 0; f < m.frames; ++f) {
    m.calc_joint_poses(f, X);
    std::string q, p;
    for (const Pose& x : X) {
      q += text_of(to_quat(x.R));
      p += text_of(x.p);
    }
    frames += "<frame type=\"normal\"><orientation>" + q + "</orientation><position>" + p + "</position></frame>\n";
  }
  return "<mvnx version=\"4\"><subject label=\"A\" frameRate=\"" + to_text(m.rate) + "\"><segments>" + segments + "</segments><joints>" +
         joints + "</joints><frames>" + frames + "</frames></subject></mvnx>";
}

template <class T>
std::string raw(T x) {
  return {reinterpret_cast<const char*>(&x), sizeof x};
}

/// A zip with uncompressed .npy files, as numpy.savez writes it.
std::string npz(const std::vector<std::tuple<std::string, std::vector<std::size_t>, std::vector<double>>>& arrays) {
  std::string out, directory;
  for (const auto& [name, shape, values] : arrays) {
    std::string sizes;
    for (const std::size_t n : shape) sizes += std::to_string(n) + ", ";
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + sizes + "), }";
    header.resize((header.size() + 11 + 63) / 64 * 64 - 11, ' ');
    header += '\n';
    std::string data = "\x93NUMPY\x01" + std::string(1, '\0') + raw(static_cast<std::uint16_t>(header.size())) + header;
    for (const double x : values) data += raw(x);
    const std::string file = name + ".npy";
    const auto size = static_cast<std::uint32_t>(data.size());
    const std::string common =
        raw(std::uint16_t{20}) + raw(std::uint32_t{0}) + raw(std::uint32_t{0x21 << 16}) +
        raw(static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(data.data()), static_cast<uInt>(data.size())))) + raw(size) +
        raw(size) + raw(static_cast<std::uint16_t>(file.size())) + raw(std::uint16_t{0});
    directory +=
        "PK\x01\x02" + raw(std::uint16_t{20}) + common + std::string(10, '\0') + raw(static_cast<std::uint32_t>(out.size())) + file;
    out += "PK\x03\x04" + common + file + data;
  }
  const auto count = static_cast<std::uint16_t>(arrays.size());
  return out + directory + "PK\x05\x06" + raw(std::uint32_t{0}) + raw(count) + raw(count) +
         raw(static_cast<std::uint32_t>(directory.size())) + raw(static_cast<std::uint32_t>(out.size())) + raw(std::uint16_t{0});
}

TEST_F(SuitsCliTest, ARecordingOfASuitIsTheMotionThatWasWritten) {
  const MeasuredMotion walk = samples::make_human_walk();
  const std::string file = write("walk.mvnx", mvnx(walk));
  const Json info = json({"info", file});
  EXPECT_EQ(info["frames"], walk.frames);
  EXPECT_EQ(info["joints_count"], walk.joint_count());
  does({"convert", file, path("back.bvh")});
  const auto back = formats::read_bvh(read(path("back.bvh")), "back.bvh");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  ASSERT_EQ(back->frames, walk.frames);
  ASSERT_EQ(back->joint_count(), walk.joint_count());
  std::vector<Pose> X, Y;
  const Vec3 shift = [&] {  // an import may move the motion as a whole, onto the floor
    walk.calc_joint_poses(0, X);
    back->calc_joint_poses(0, Y);
    return Y[0].p - X[0].p;
  }();
  for (int f = 0; f < walk.frames; f += 10) {
    walk.calc_joint_poses(f, X);
    back->calc_joint_poses(f, Y);
    for (std::size_t i = 0; i < X.size(); ++i) EXPECT_LT(norm(Y[i].p - X[i].p - shift), 1e-3) << f << " " << i;
  }
  const Json imported = json({"import", file, "--dry-run"});
  EXPECT_TRUE(imported["files"][0]["human"].get<bool>());
  const Json run = json({"run", file, "--duration", "0.5"});
  EXPECT_TRUE(run["release_time"].is_null());
  EXPECT_FALSE(run["fell"].get<bool>());
}

TEST_F(SuitsCliTest, AnSmplMotionIsImportedAndRun) {
  // A person who stands still: no rotations, and the pelvis 0.95 m above the floor of a file with Y up.
  const std::size_t frames = 60;
  std::vector<double> trans;
  for (std::size_t f = 0; f < frames; ++f) trans.insert(trans.end(), {0, 0.95, 0});
  const std::string file = write(
      "stand.npz",
      npz({{"poses", {frames, 72}, std::vector<double>(frames * 72, 0)}, {"trans", {frames, 3}, trans}, {"mocap_framerate", {}, {60}}}));
  const Json info = json({"info", file});
  EXPECT_EQ(info["frames"], 60);
  EXPECT_EQ(info["rate"], 60);
  EXPECT_EQ(info["joints_count"], 24);
  does({"convert", file, path("stand.bvh")});
  EXPECT_EQ(formats::read_bvh(read(path("stand.bvh")), "stand.bvh")->frames, 60);
  EXPECT_TRUE(json({"import", file, "--dry-run"})["files"][0]["human"].get<bool>());
  const Json run = json({"run", file, "--duration", "0.5"});
  EXPECT_TRUE(run["release_time"].is_null());
  EXPECT_FALSE(run["fell"].get<bool>());
  fails({"info", write("bad.npz", "PK")}, "bad.npz");
  fails({"info", write("bad.mvnx", "<mvnx/>")}, "subject");
}

}  // namespace
}  // namespace ugoki::cli
