#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"
#include "ugoki/base/number.h"
#include "ugoki/base/printable.h"
#include "ugoki/base/result.h"
#include "ugoki/base/sha256.h"

namespace ugoki {
namespace {

TEST(Printable, ControlsBecomeEscapes) {
  EXPECT_EQ(printable("walk \u6b69\u304f \U0001F600 \u00e9"), "walk \u6b69\u304f \U0001F600 \u00e9");
  EXPECT_EQ(printable(std::string_view("\0\x1b]0;x\a\r\n\t\x7f", 11)), "\\x00\\x1b]0;x\\x07\\x0d\\x0a\\x09\\x7f");
  EXPECT_EQ(printable("\u0080\u009b\u009f\u00a0"), "\\x80\\x9b\\x9f\u00a0");
  EXPECT_EQ(printable("\u202a\u202e\u2066\u2069\u2028\u200f\u202f\u206a"), "\\u202a\\u202e\\u2066\\u2069\\u2028\\u200f\u202f\u206a");
  // Bytes that are not UTF-8: single invalid bytes, an overlong form, a surrogate, a code above U+10FFFF, an incomplete character.
  EXPECT_EQ(printable("\x9b\xff\xc0\xaf"), "\\x9b\\xff\\xc0\\xaf");
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(printable("a\xe2\x80"), "a\\xe2\\x80");
}

TEST(Printable, JsonKeepsItsMeaning) {
  EXPECT_EQ(printable_json("{\n  \"a\": \"\\u001b\x7f\u009b\u202e\u00e9\"\n}"), "{\n  \"a\": \"\\u001b\\u007f\\u009b\\u202e\u00e9\"\n}");
}

TEST(Number, ParsesTheWholeText) {
  EXPECT_EQ(parse_double("1.5"), 1.5);
  EXPECT_EQ(parse_double("-1e-3"), -1e-3);
  EXPECT_EQ(parse_double("+2"), 2.0);
  EXPECT_EQ(parse_double(".5"), 0.5);
  EXPECT_EQ(parse_double("5."), 5.0);
  EXPECT_EQ(parse_double("1E5"), 1e5);
  EXPECT_EQ(parse_double("0.1"), 0.1);
  EXPECT_TRUE(std::signbit(*parse_double("-0")));
  EXPECT_EQ(parse_double("4.9406564584124654e-324"), 4.9406564584124654e-324);
  const std::string many_nines(200, '9');
  EXPECT_EQ(parse_double("0." + many_nines), 1.0);
  EXPECT_EQ(parse_double("1e-999"), 0.0);
  EXPECT_EQ(parse_double("-1e-999"), 0.0);
  EXPECT_EQ(parse_double("+1e-5"), 1e-5);
}

TEST(Number, RejectsTextThatIsNotOneFiniteNumber) {
  for (const char* text : {"",         " ",    " 1",    "1 ",     "1.2.3", "1,5", "--1", "e5", "1e",  "nan",  "inf", "-inf",
                           "infinity", "0x10", "1e999", "-1e999", "1d",    "one", "+",   ".",  "1\t", "\xff", "1e+"})
    EXPECT_EQ(parse_double(text), std::nullopt) << '"' << text << '"';
  EXPECT_EQ(parse_double(std::string_view("1\0 2", 4)), std::nullopt);
  EXPECT_EQ(parse_double(std::string(1000, '9')), std::nullopt);  // overflow is refused
  const char tail[] = {'7', '7', '8'};
  EXPECT_EQ(parse_double(std::string_view(tail, 2)), 77.0);  // the parser does not read past the end of the text
}

TEST(Number, ParsesIntegersAndRejectsOverflow) {
  EXPECT_EQ(parse_long("42"), 42);
  EXPECT_EQ(parse_long("-7"), -7);
  EXPECT_EQ(parse_long("+7"), 7);
  EXPECT_EQ(parse_long("9223372036854775807"), 9223372036854775807L);
  for (const char* text : {"", "+", "-", "1.0", "1e3", " 1", "1 ", "9223372036854775808", "0x1", "+-1", "--1"})
    EXPECT_EQ(parse_long(text), std::nullopt) << text;
}

TEST(Number, TextRoundTripPreservesEveryBit) {
  std::mt19937_64 engine(1);
  for (int i = 0; i < 100000; ++i) {
    const std::uint64_t bits = engine();
    double x;
    std::memcpy(&x, &bits, sizeof x);
    if (!std::isfinite(x)) continue;
    const auto back = parse_double(to_text(x));
    ASSERT_TRUE(back.has_value()) << to_text(x);
    ASSERT_EQ(std::memcmp(&x, &*back, sizeof x), 0) << to_text(x);
  }
  EXPECT_EQ(to_text(0.1), "0.1");
  EXPECT_EQ(to_text(1e21), "1e+21");
  EXPECT_EQ(parse_double(to_text(std::numeric_limits<double>::infinity())), std::nullopt);
}

TEST(Number, PrintsAFixedNumberOfDigits) {
  EXPECT_EQ(to_fixed(1.005, 1), "1.0");
  EXPECT_EQ(to_fixed(-2.25, 2), "-2.25");
  EXPECT_EQ(to_fixed(3, 0), "3");
  EXPECT_EQ(to_fixed(1e300, 0).size(), 301U);
  EXPECT_EQ(to_fixed(-1.7976931348623157e308, 1000).size(), 651U);  // digits after the point are limited to 340
  EXPECT_EQ(to_fixed(2.5, -3), "2");
}

TEST(Number, ConversionIgnoresTheLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const char* comma = nullptr;
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "nl_NL.UTF-8"})
    if (comma == nullptr && std::setlocale(LC_ALL, name) != nullptr) comma = name;
  if (comma == nullptr) GTEST_SKIP() << "No locale with a decimal comma is installed here.";
  const auto parsed = parse_double("1.5");
  const std::string text = to_text(1.5), fixed = to_fixed(1.5, 1);
  std::setlocale(LC_ALL, before.c_str());
  EXPECT_EQ(parsed, 1.5);
  EXPECT_EQ(text, "1.5");
  EXPECT_EQ(fixed, "1.5");
}

// Published values of 64-bit FNV-1a (Fowler, Noll, Vo; draft-eastlake-fnv, test vectors).
TEST(Hash, MatchesPublishedTestVectors) {
  Hash64 empty;
  EXPECT_EQ(empty.value(), 0xcbf29ce484222325ULL);
  Hash64 a;
  a.add_bytes("a", 1);
  EXPECT_EQ(a.value(), 0xaf63dc4c8601ec8cULL);
  Hash64 foobar;
  foobar.add_bytes("foobar", 6);
  EXPECT_EQ(foobar.value(), 0x85944171f73967e8ULL);
  EXPECT_EQ(foobar.hex(), "85944171f73967e8");
}

TEST(Hash, DependsOnEveryBitOfADouble) {
  const double one[] = {1.0, 0.0}, other[] = {1.0, -0.0};
  Hash64 a, b, c;
  a.add(std::span<const double>(one));
  b.add(std::span<const double>(other));
  c.add(1.0);
  c.add(0.0);
  EXPECT_NE(a.value(), b.value());
  EXPECT_EQ(a.value(), c.value());
  Hash64 d;
  d.add(std::uint64_t{0x3ff0000000000000ULL});
  d.add(std::uint64_t{0});
  EXPECT_EQ(d.value(), c.value());  // d hashes the bits of 1.0 and 0.0
}

TEST(Result, ErrorTextHasLocationMessageAndRemedy) {
  const Result<int> r = fail(ErrorCode::syntax, "walk.bvh:17", "A number is missing.", "Add it.");
  ASSERT_FALSE(r.has_value());
  EXPECT_EQ(r.error().text(), "walk.bvh:17: A number is missing. Add it.");
  Error e;
  EXPECT_TRUE(e.empty());
  e.add(ErrorCode::range, "", "The value is too large.");
  e.add(ErrorCode::unknown, "link x", "The link does not exist.");
  EXPECT_EQ(e.text(), "The value is too large.\nlink x: The link does not exist.");
  const Result<int> whole = fail(e);
  EXPECT_EQ(whole.error().problems.size(), 2U);
  EXPECT_EQ(whole.error().problems[1].code, ErrorCode::unknown);
  const Result<int> good = 3;
  EXPECT_EQ(*good, 3);
}

TEST(CheckDeathTest, PrintsTheFailedConditionAndAborts) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_DEATH(UGOKI_CHECK(1 + 1 == 3), "check failed: 1 \\+ 1 == 3");
  UGOKI_CHECK(1 + 1 == 2);
}

// FIPS 180-4, examples of the standard's test vectors.
TEST(Sha256, MatchesPublishedTestVectors) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

}  // namespace
}  // namespace ugoki
