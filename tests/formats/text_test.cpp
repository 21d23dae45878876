// Number parsing, names, and line counting of text formats.
#include "ugoki/formats/text.h"

#include <gtest/gtest.h>

#include <random>

#include "ugoki/base/number.h"

namespace ugoki::formats {
namespace {

TEST(Numbers, FastPathMatchesParseDoubleBitForBit) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200'000; ++i) {
    const int digits = 1 + static_cast<int>(random() % 30), point = static_cast<int>(random() % 20);
    std::string text = random() % 2 ? "-" : "";
    for (int k = 0; k < digits; ++k) {
      if (k == point) text += '.';
      text += static_cast<char>('0' + random() % 10);
    }
    const auto slow = parse_double(text), fast = measured_number(text);
    if (slow && std::abs(*slow) <= max_magnitude) {
      ASSERT_TRUE(fast.has_value()) << text;
      ASSERT_EQ(*fast, *slow) << text;
    } else {
      ASSERT_FALSE(fast.has_value()) << text;
    }
  }
}

TEST(Numbers, MalformedOrTooLargeNumbersAreRejected) {
  for (const char* text : {"", "-", ".", "-.", "1.2.3", "1e", "0x10", "nan", "inf", "1,5", "1e400", "2e9", "--1", "1-", "e5", "+-1"})
    EXPECT_FALSE(measured_number(text).has_value()) << text;
  for (const char* text : {"1.", ".5", "+2", "-0", "1e3", "1E-3", "00012"}) EXPECT_TRUE(measured_number(text).has_value()) << text;
}

TEST(Numbers, FaultMessageNamesTheCause) {
  EXPECT_NE(number_fault("1,5").message.find("comma"), std::string::npos);
  EXPECT_NE(number_fault("-1.#IND").message.find("finite"), std::string::npos);
  EXPECT_NE(number_fault("NaN").message.find("finite"), std::string::npos);
  EXPECT_NE(number_fault("1e12").message.find("large"), std::string::npos);
  EXPECT_EQ(number_fault("").code, ErrorCode::truncated);
}

TEST(Names, InvalidUtf8IsReadAsLatin1) {
  EXPECT_EQ(utf8("Hips"), "Hips");
  EXPECT_EQ(utf8("\xE5\x8B\x95\xE3\x81\x8D"), "\xE5\x8B\x95\xE3\x81\x8D");
  EXPECT_EQ(utf8("Jos\xE9"), "Jos\xC3\xA9");
  EXPECT_EQ(utf8("\xC0\x80"), "\xC3\x80\xC2\x80") << "overlong";
  EXPECT_EQ(utf8("\xED\xA0\x80").size(), 6U) << "surrogate";
}

TEST(Lines, EveryKindOfLineEndIsCountedOnce) {
  Scanner s("a\nb\r\nc\rd\n\n e");
  for (const auto& [word, line] : {std::pair{"a", 1}, {"b", 2}, {"c", 3}, {"d", 4}, {"e", 6}}) {
    EXPECT_EQ(s.word(), word);
    EXPECT_EQ(s.line(), line);
  }
  EXPECT_TRUE(s.word().empty());
}

TEST(Names, StemOmitsFoldersAndExtension) {
  EXPECT_EQ(stem_of("a/b.c/02_01.amc"), "02_01");
  EXPECT_EQ(stem_of("C:\\x\\walk.one.bvh"), "walk.one");
  EXPECT_EQ(stem_of(".bvh"), ".bvh");
}

}  // namespace
}  // namespace ugoki::formats
