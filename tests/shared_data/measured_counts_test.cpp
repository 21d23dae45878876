// Motions and recordings match a simple independent count of the words and bytes of their file.
#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <set>
#include <sstream>

#include "shared_files.h"
#include "ugoki/formats/asf.h"

namespace ugoki {
namespace {

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> out;
  for (std::string w; in >> w;) out.push_back(w);
  return out;
}

/// Non-empty lines of a text; line ends are LF, CR LF or CR.
std::vector<std::string> lines_of(std::string text) {
  std::ranges::replace(text, '\r', '\n');
  std::istringstream in(text);
  std::vector<std::string> out;
  for (std::string l; std::getline(in, l);)
    if (!l.empty()) out.push_back(l);
  return out;
}

/// Compares what our reader returns with counts taken from the text of the file: joints, end sites, channels, frames and motion values.
TEST(SharedCounts, Bvh) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".bvh"})) {
    SCOPED_TRACE(path);
    const std::vector<std::string> words = words_of(shared_text(path));
    std::size_t joints = 0, ends = 0, channels = 0, numbers = 0;
    long frames = -1;
    double time = 0;
    for (std::size_t i = 0; i < words.size(); ++i) {
      const std::string& w = words[i];
      joints += w == "ROOT" || w == "JOINT";
      ends += w == "End";
      if (w == "CHANNELS") channels += static_cast<std::size_t>(std::stol(words.at(i + 1)));
      if (w == "Frames:") frames = std::stol(words.at(i + 1));
      if (w == "Time:") {
        time = std::strtod(words.at(i + 1).c_str(), nullptr);
        numbers = words.size() - i - 2;
      }
    }
    const MeasuredMotion m = read_motions(path).at(0);
    std::size_t end_sites = 0;
    for (const SkeletonJoint& j : m.skeleton.joints) end_sites += j.end_sites.size();
    EXPECT_EQ(m.skeleton.joints.size(), joints);
    EXPECT_EQ(end_sites, ends);
    EXPECT_EQ(m.frames, frames);
    EXPECT_EQ(numbers, channels * static_cast<std::size_t>(m.frames));
    EXPECT_NEAR(m.rate * time, 1, 2e-3) << "the frame time may be rounded";
  }
}

TEST(SharedCounts, AsfAndAmc) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".asf"})) {
    SCOPED_TRACE(path);
    std::size_t bones = 0, dofs = 0, ends = 0;
    std::set<std::string> parents, names;
    std::string section;
    for (const std::string& line : lines_of(shared_text(path))) {
      const std::vector<std::string> w = words_of(line);
      if (w.empty()) continue;
      if (w[0][0] == ':') section = w[0];
      if (section == ":bonedata" && w[0] == "begin") ++bones;
      if (section == ":bonedata" && w[0] == "name") names.insert(w.at(1));
      if (section == ":bonedata" && w[0] == "dof") dofs += w.size() - 1;
      if (section == ":hierarchy" && w.size() > 1) parents.insert(w[0]);
    }
    for (const std::string& n : names) ends += !parents.contains(n);
    const auto asf = formats::read_asf(shared_text(path), path);
    ASSERT_TRUE(asf) << asf.error().text();
    std::size_t read_dofs = 0, read_ends = 0;
    for (std::size_t i = 1; i < asf->bones.size(); ++i) read_dofs += asf->bones[i].dofs.size();
    for (const SkeletonJoint& j : asf->skeleton.joints) read_ends += j.end_sites.size();
    EXPECT_EQ(asf->skeleton.joints.size(), bones + 1);
    EXPECT_EQ(read_dofs, dofs);
    EXPECT_EQ(read_ends, ends);
  }
  for (const std::string& path : shared_files({".amc"})) {
    SCOPED_TRACE(path);
    int frames = 0;
    for (const std::string& line : lines_of(shared_text(path)))
      frames += std::isdigit(static_cast<unsigned char>(line[0])) != 0 && words_of(line).size() == 1;
    EXPECT_EQ(read_motions(path).at(0).frames, frames);
  }
}

/// Decodes words and floats of a C3D file in the byte order of its processor type.
struct C3dHeader {
  std::string bytes;
  int processor = 84;

  explicit C3dHeader(std::string file) : bytes(std::move(file)) { processor = byte(512 * (static_cast<std::size_t>(byte(0)) - 1) + 3); }
  int byte(std::size_t at) const { return static_cast<unsigned char>(bytes.at(at)); }
  int word(std::size_t at) const { return processor == 86 ? 256 * byte(at) + byte(at + 1) : byte(at) + 256 * byte(at + 1); }
  double number(std::size_t at) const {
    const auto w = [&](std::size_t k) { return static_cast<std::uint32_t>(word(at + 2 * k)); };
    if (processor == 84) return static_cast<double>(std::bit_cast<float>(w(0) | w(1) << 16));
    const double big = static_cast<double>(std::bit_cast<float>(w(0) << 16 | w(1)));
    return processor == 85 ? big / 4 : big;
  }
};

/// Compares with counts from the header and with the markers of the first frame, decoded here.
TEST(SharedCounts, C3d) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".c3d"})) {
    SCOPED_TRACE(path);
    const C3dHeader h(shared_text(path));
    ASSERT_EQ(h.byte(1), 0x50);
    const int markers = h.word(2), analog = h.word(4), per_frame = h.word(18);
    const MarkerMotion m = read_markers(path);
    EXPECT_EQ(m.marker_count(), markers);
    EXPECT_EQ(m.first_frame, h.word(6));
    EXPECT_EQ(m.frames, h.word(8) - h.word(6) + 1);
    EXPECT_EQ(m.rate, h.number(20));
    EXPECT_EQ(static_cast<int>(m.analog.size()) * m.samples_per_frame(), analog);
    if (analog > 0) EXPECT_EQ(m.samples_per_frame(), per_frame);
    const double scale = h.number(12);
    const std::size_t size = scale < 0 ? 4 : 2, frame = size * static_cast<std::size_t>(4 * markers + analog);
    const std::size_t data = 512 * (static_cast<std::size_t>(h.word(16)) - 1);
    EXPECT_GE(h.bytes.size(), data + frame * static_cast<std::size_t>(m.frames));
    EXPECT_LT(h.bytes.size(), data + frame * static_cast<std::size_t>(m.frames) + 512 * 20);
    for (int f = 0; f < m.frames; f += 10)
      for (int i = 0; i < markers; ++i) {
        double raw[4];
        for (std::size_t k = 0; k < 4; ++k) {
          const std::size_t at = data + frame * static_cast<std::size_t>(f) + size * (4 * static_cast<std::size_t>(i) + k);
          raw[k] = scale < 0 ? h.number(at) : scale * static_cast<std::int16_t>(h.word(at));
        }
        EXPECT_EQ(m.seen(f, i), raw[3] >= 0);
        if (!m.seen(f, i)) continue;
        // Compare distances from the origin, which do not depend on the axes.
        EXPECT_NEAR(norm(m.at(f, i)), m.unit * std::hypot(raw[0], raw[1], raw[2]), 1e-9);
      }
  }
}

TEST(SharedCounts, Trc) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".trc"})) {
    SCOPED_TRACE(path);
    std::string text = shared_text(path);
    std::ranges::replace(text, ',', '\t');
    const std::vector<std::string> lines = lines_of(text);
    const std::vector<std::string> head = words_of(lines.at(2));
    int rows = 0;
    for (std::size_t i = 5; i < lines.size(); ++i) {
      const std::vector<std::string> w = words_of(lines[i]);
      rows += !w.empty() && std::ranges::all_of(w[0], [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; });
    }
    const MarkerMotion m = read_markers(path);
    EXPECT_EQ(m.rate, std::strtod(head.at(0).c_str(), nullptr));
    EXPECT_LE(m.frames, std::stoi(head.at(2))) << "a file may declare more rows than it has";
    EXPECT_EQ(m.frames, rows);
    EXPECT_EQ(m.marker_count(), std::stoi(head.at(3)));
    EXPECT_EQ(m.unit, head.at(4) == "mm" ? 0.001 : head.at(4) == "cm" ? 0.01 : 1);
    EXPECT_EQ(static_cast<std::ptrdiff_t>(m.labels.size()), std::ranges::count(lines.at(4), 'X'));
  }
}

}  // namespace
}  // namespace ugoki
