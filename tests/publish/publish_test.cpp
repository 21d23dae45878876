// Pages, payloads and surfaces of exported content.

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "../content/fixture.h"
#include "ugoki/base/base64.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/json/json.h"
#include "ugoki/publish/page.h"
#include "ugoki/publish/payload.h"
#include "ugoki/publish/shape_surface.h"

namespace ugoki::publish {
namespace {

std::vector<std::byte> random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> out(size);
  for (std::byte& b : out) b = static_cast<std::byte>(random() % 7);  // compressible
  return out;
}

/// Unpacks gzip with zlib's own reader.
std::vector<std::byte> unpacked(const std::vector<std::uint8_t>& packed, std::size_t size) {
  std::vector<std::byte> out(size + 1);
  z_stream s{};
  EXPECT_EQ(inflateInit2(&s, 15 + 16), Z_OK);
  s.next_in = const_cast<Bytef*>(packed.data());
  s.avail_in = static_cast<uInt>(packed.size());
  s.next_out = reinterpret_cast<Bytef*>(out.data());
  s.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(inflate(&s, Z_FINISH), Z_STREAM_END);
  out.resize(s.total_out);
  inflateEnd(&s);
  return out;
}

const char* page_text =
    "<html lang=\"en\"><title>@UGOKI_TITLE@</title><script id=\"ugoki-first\">@UGOKI_FIRST@</script><script id=\"ugoki-content\">@UGOKI_CONTENT@</script><script "
    "id=\"ugoki-engine\">ENGINE</script>";

TEST(Page, ContainsTheContentAndAnEscapedTitle) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{65536}, std::size_t{300'001}}) {
    const auto ugx = random_bytes(size, 5);
    const auto page = make_page(page_text, "a </title><b> & \"c\"", ugx);
    ASSERT_TRUE(page);
    EXPECT_NE(page->find("<title>a &lt;/title&gt;&lt;b&gt; &amp; &quot;c&quot;</title>"), std::string::npos);
    const std::size_t at = page->find("ugoki-content\">") + 15;
    const auto packed = from_base64(page->substr(at, page->find('<', at) - at));
    ASSERT_TRUE(packed);
    EXPECT_EQ(unpacked(*packed, size), ugx);
    EXPECT_NE(page->find("ENGINE"), std::string::npos);
  }
}

TEST(Page, OfANativeProgramHasNeitherEngineNorContent) {
  const auto page = make_page(page_text, "x", random_bytes(100, 1), PageEngine::native);
  ASSERT_TRUE(page);
  EXPECT_EQ(page->find("ENGINE"), std::string::npos);
  EXPECT_NE(page->find("ugoki-content\"></script>"), std::string::npos);
  EXPECT_NE(page->find("data-engine=\"native\""), std::string::npos);
}

TEST(Page, ContainsItsFirstPicture) {
  const auto ugx = content::generate(content::testing::make_scenario(), content::testing::make_resources());
  ASSERT_TRUE(ugx);
  const auto first = json::parse_json(first_picture(*ugx), "first picture");
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_EQ((*first)["scene"]["characters"].size(), content::testing::make_scenario().characters.size());
  EXPECT_TRUE((*first)["devices"].is_object());
  auto player = content::Player::open(*ugx);
  ASSERT_TRUE(player);
  content::DisplayFrame frame;
  player->display_frame(frame);
  std::vector<std::byte> bytes;
  content::encode_frame(frame, 0, content::frame_simulate, bytes);
  const auto drawn = from_base64((*first)["frame"].get<std::string>());
  ASSERT_TRUE(drawn);
  EXPECT_TRUE(std::ranges::equal(std::as_bytes(std::span(*drawn)), bytes));
  const auto page = make_page(page_text, "x", *ugx);
  ASSERT_TRUE(page);
  EXPECT_EQ(page->find("ugoki-first\"></script>"), std::string::npos);
}

TEST(Page, OfContentThatCannotBeOpenedHasNoFirstPicture) {
  EXPECT_TRUE(first_picture(random_bytes(100, 1)).empty());
  const auto page = make_page(page_text, "x", random_bytes(100, 1));
  ASSERT_TRUE(page);
  EXPECT_NE(page->find("ugoki-first\"></script>"), std::string::npos);
}

TEST(Page, WithoutItsMarksIsRefused) { EXPECT_FALSE(make_page("<html></html>", "x", {})); }

TEST(Payload, IsReadAsWritten) {
  for (const std::size_t size : {0UL, 1UL, 63UL, 64UL, 65UL, 5000UL}) {
    const auto program = random_bytes(1000 + size, 2), ugx = random_bytes(size, 3);
    const std::string page(size / 2, 'p');
    const auto file = append_payload(program, page, ugx);
    const auto read = read_payload(file, "walk");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->page, page);
    EXPECT_TRUE(std::ranges::equal(read->ugx, ugx));
    EXPECT_EQ((read->ugx.data() - file.data()) % 64, 0) << "the content should be aligned, so that it is used without copying";
    EXPECT_TRUE(std::ranges::equal(std::span(file).first(program.size()), program)) << "the program itself should be unchanged";
  }
}

TEST(Payload, LibrariesAreReadAsWritten) {
  const auto first = random_bytes(70, 4), second = random_bytes(0, 5);
  const std::vector<CarriedLibrary> libraries = {{"springs-0123.so", first}, {"empty.so", second}};
  const auto file = append_payload(random_bytes(100, 1), "page", random_bytes(10, 2), libraries);
  const auto read = read_payload(file, "walk");
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(read->libraries.size(), 2u);
  EXPECT_EQ(read->libraries[0].name, "springs-0123.so");
  EXPECT_TRUE(std::ranges::equal(read->libraries[0].bytes, first));
  EXPECT_TRUE(read->libraries[1].bytes.empty());
}

TEST(Payload, DamageOfEveryKindIsRefused) {
  const auto code = random_bytes(300, 7);
  const std::vector<CarriedLibrary> libraries = {{"springs.so", code}};
  const auto file = append_payload(random_bytes(500, 1), "page of the content", random_bytes(700, 2), libraries);
  EXPECT_FALSE(read_payload(std::span(file).first(500), "walk")) << "a program without payload";
  for (std::size_t size = 0; size < file.size(); size += 7) EXPECT_FALSE(read_payload(std::span(file).first(size), "walk")) << size;
  for (std::size_t at = file.size() - 64 - 128; at < file.size(); ++at) {  // table and trailer
    const std::size_t name_end = file.size() - 64 - 112 + std::string_view("springs.so").size() + 1;
    if (at >= name_end && at < file.size() - 64) continue;  // bytes after the end of the name have no meaning
    auto damaged = file;
    damaged[at] ^= std::byte{0x80};
    EXPECT_FALSE(read_payload(damaged, "walk")) << at - (file.size() - 64);
  }
  auto damaged = file;
  damaged[damaged.size() - 300] ^= std::byte{1};
  const auto read = read_payload(damaged, "walk");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().text().find("checksum"), std::string::npos);
}

/// Volume inside a closed surface, by the divergence theorem; positive if the triangles are counter-clockwise seen from outside.
double volume_of(const Surface& s) {
  double six = 0;
  for (const auto& t : s.triangles) six += dot(s.points[t[0]], cross(s.points[t[1]], s.points[t[2]]));
  return six / 6;
}

TEST(ShapeSurface, EnclosesTheVolumeOfTheShapeWithNormalsOutwards) {
  const Pose X = {to_matrix(axis_angle(normalized(Vec3{1, 2, 3}), 0.7)), {0.3, -0.2, 0.9}};
  std::vector<Shape> shapes = {Shape::sphere(0.3, X), Shape::capsule(0.1, {0.1, 0, 0}, {0.4, 0.3, -0.2}), Shape::box({0.1, 0.2, 0.3}, X),
                               Shape::cylinder(0.2, 0.5, X), Shape::ellipsoid({0.1, 0.25, 0.4}, X)};
  const std::vector<Vec3> corners = {{0, 0, 0}, {0.5, 0, 0}, {0, 0.4, 0}, {0, 0, 0.6}};
  const std::vector<Triangle> sides = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  shapes.push_back(Shape::mesh(make_geometry(corners, sides, true, "test").value(), X));
  for (const Shape& shape : shapes) {
    SCOPED_TRACE(name_of(shape.type));
    Surface s;
    add_surface(shape, s);
    ASSERT_EQ(s.points.size(), s.normals.size());
    EXPECT_NEAR(volume_of(s), volume(shape), 0.035 * volume(shape)) << "the volume is smaller because of the chords of 24 sides";
    EXPECT_LE(volume_of(s), volume(shape) * (1 + 1e-9));
    for (const Vec3& n : s.normals) EXPECT_NEAR(norm(n), 1, 1e-9);
    // The surface is closed: every edge, identified by the positions of its ends, is used once in each direction.
    std::map<std::array<long, 6>, int> edges;
    const auto key = [&](std::uint32_t a, std::uint32_t b) {
      std::array<long, 6> k{};
      for (std::size_t i = 0; i < 3; ++i) {
        k[i] = std::lround(1e7 * s.points[a][static_cast<int>(i)]);
        k[i + 3] = std::lround(1e7 * s.points[b][static_cast<int>(i)]);
      }
      return k;
    };
    for (const auto& t : s.triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        ++edges[key(t[i], t[(i + 1) % 3])];
        --edges[key(t[(i + 1) % 3], t[i])];
        const Vec3 flat = cross(s.points[t[1]] - s.points[t[0]], s.points[t[2]] - s.points[t[0]]);
        EXPECT_GT(dot(flat, s.normals[t[i]]), 0) << "the normal of a vertex should point to the outside of its triangles";
      }
    for (const auto& [edge, balance] : edges) EXPECT_EQ(balance, 0);
  }
}

}  // namespace
}  // namespace ugoki::publish
