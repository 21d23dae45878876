#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/json/fields.h"

namespace ugoki::json {
namespace {

TEST(Json, SyntaxErrorsHaveTheirLineAndColumn) {
  struct Case {
    std::string text, location;
    ErrorCode code;
  };
  const Case cases[] = {
      {"", "f:1:1", ErrorCode::truncated},
      {"\n\n", "f:3:1", ErrorCode::truncated},
      {"{\"a\":\n[1, 2", "f:2:6", ErrorCode::truncated},
      {"{\"a\": \"no end", "f:1:14", ErrorCode::truncated},
      {"{\"a\": 1}}", "f:1:9", ErrorCode::syntax},
      {"{\n\"a\" 1}", "f:2:5", ErrorCode::syntax},
      {"{\n\"\u00e9\" 1}", "f:2:5", ErrorCode::syntax},  // columns count characters, not bytes
      {"\xEF\xBB\xBF{\"a\" 1}", "f:1:6", ErrorCode::syntax},
      {"{\"a\": 1,\r\n \"b\": 2 \"long name\": 3}", "f:2:9", ErrorCode::syntax},  // the first character of the unexpected token
      {"[1,\n2,\n]", "f:3:1", ErrorCode::syntax},
      {"[1,\n nul]", "f:2:5", ErrorCode::syntax},
      {"[1,\n1e999]", "f:2:1", ErrorCode::range},
      {"{\"a\": -1.5e+4000 }", "f:1:7", ErrorCode::range},
      {"[\"\xFF\"]", "f:1:3", ErrorCode::syntax},
      {std::string("\0", 1), "f:1:1", ErrorCode::syntax},
      {std::string("{\"a\":\n1}\0}", 10), "f:2:3", ErrorCode::syntax},  // text after a zero byte must not be ignored silently
      {"{\"a\": [{\"b\": 1, \"c\": {\"b\": 2}},\n {\"b\": 1,\n\"d\": \"b\", \"b\" : 3}]}", "f:3:12", ErrorCode::duplicate},
      {std::string(max_depth + 1, '[') + std::string(max_depth + 1, ']'), "f:1:101", ErrorCode::range},
  };
  for (const Case& c : cases) {
    const auto read = parse_json(c.text, "f");
    ASSERT_FALSE(read) << c.text;
    EXPECT_EQ(read.error().problems[0].location, c.location) << c.text;
    EXPECT_EQ(read.error().problems[0].code, c.code) << c.text;
    EXPECT_FALSE(read.error().problems[0].remedy.empty());
  }
  EXPECT_TRUE(parse_json(std::string(max_depth, '[') + std::string(max_depth, ']'), "f"));
  EXPECT_TRUE(parse_json("[\"" + std::string(2 * max_depth, '[') + "\"]", "f")) << "brackets inside a string do not count as nesting";
  EXPECT_TRUE(parse_json("\xEF\xBB\xBF{}", "f")) << "a byte order mark is accepted";
  EXPECT_FALSE(parse_json("[1, 2]", "f", 5)) << "the text is larger than the limit of 5 bytes";
}

TEST(Json, NumbersTooLargeForADoubleAreReported) {
  for (const char* number : {"1e999", "-1e309", "1797693134862315907729305190789e400"}) {
    const auto read = parse_json(std::string("{\"a\": ") + number + "}", "f");
    ASSERT_FALSE(read) << number;
    EXPECT_EQ(read.error().problems[0].location, "f:1:7");
    EXPECT_EQ(read.error().problems[0].code, ErrorCode::range);
    EXPECT_NE(read.error().text().find(std::string("The number ") + number + " is too large"), std::string::npos) << read.error().text();
  }
  for (const char* number : {"1.7976931348623157e308", "-5e-324", "1e-999", "123456789012345678901234567890"}) {
    const auto read = parse_json(number, "f");
    ASSERT_TRUE(read) << number;
    EXPECT_TRUE(std::isfinite(read->get<double>())) << number;
  }
}

TEST(Json, FieldsReportEveryProblemWithItsPath) {
  const auto document = parse_json(
      R"({"n": "x", "i": 1.5, "b": 0, "t": 3, "v": [1, 2], "u": [1, 2, 3, 4], "w": [1, "2"], "l": {}, "m": [1, 2, 3], "extra": 0})", "f");
  ASSERT_TRUE(document);
  Error problems;
  Fields f(*document, "f:", problems);
  double n = 7, v[3] = {7, 7, 7}, w[2] = {7, 7};
  int i = 7;
  bool b = true;
  std::string t = "seven";
  f.number("n", n);
  f.integer("i", i);
  f.boolean("b", b);
  f.text("t", t);
  EXPECT_FALSE(f.numbers("v", v));
  EXPECT_FALSE(f.numbers("u", v));
  EXPECT_FALSE(f.numbers("w", w));
  EXPECT_EQ(f.list("l", 10, "entries"), nullptr);
  EXPECT_EQ(f.list("m", 2, "entries"), nullptr);
  f.require("absent", "it");
  f.number("absent", n);
  f.refuse_others();
  std::vector<std::string> locations;
  for (const Problem& p : problems.problems) {
    locations.push_back(p.location);
    EXPECT_FALSE(p.message.empty() || p.remedy.empty()) << p.text();
  }
  EXPECT_EQ(locations, (std::vector<std::string>{"f:n", "f:i", "f:b", "f:t", "f:v", "f:u", "f:w", "f:l", "f:m", "f:absent", "f:extra"}));
  EXPECT_EQ(n, 7);
  EXPECT_EQ(i, 7);
  EXPECT_TRUE(b);
  EXPECT_EQ(t, "seven");
  EXPECT_EQ(v[0], 7);
  EXPECT_EQ(w[0], 7) << "an invalid list changes no value";
}

TEST(Json, RenamedFieldsAreFoundUnderBothNames) {
  Json object = {{"old", 1}, {"other", 2}};
  Error problems;
  EXPECT_EQ(Fields(object, "x", problems).renamed("new", "old"), "old");
  EXPECT_EQ(Fields(object, "x", problems).renamed("other", "old"), "other") << "the present name wins";
  EXPECT_EQ(Fields(object, "x", problems).renamed("new", "absent"), "new");
  rename_field(object, "old", "new");
  EXPECT_EQ(object, (Json{{"other", 2}, {"new", 1}}));
  rename_field(object, "new", "other");
  EXPECT_EQ(object, (Json{{"other", 2}, {"new", 1}})) << "an existing field is kept";
}

TEST(Json, FieldsReadValidValues) {
  const auto document = parse_json(R"({"n": -0.0, "i": -3, "b": false, "t": "\u52d5", "v": [1, 2.5, -0.0], "l": [{"n": 2}]})", "f");
  ASSERT_TRUE(document);
  Error problems;
  Fields f(*document, "f", problems);
  double n = 7, v[3] = {};
  int i = 7;
  bool b = true;
  std::string t;
  f.number("n", n);
  f.integer("i", i);
  f.boolean("b", b);
  f.text("t", t);
  EXPECT_TRUE(f.numbers("v", v));
  const Json* l = f.list("l", 1, "entries");
  ASSERT_NE(l, nullptr);
  Fields inner((*l)[0], f.path("l") + "/0", problems);
  EXPECT_EQ(inner.path("n"), "f/l/0/n");
  inner.number("n", n);
  EXPECT_EQ(n, 2);
  f.refuse_others();
  EXPECT_TRUE(problems.empty()) << problems.text();
  EXPECT_EQ(i, -3);
  EXPECT_FALSE(b);
  EXPECT_EQ(t, "\u52d5");
  EXPECT_TRUE(v[2] == 0 && std::signbit(v[2])) << "negative zero is preserved";
}

TEST(Json, ErrorsOfAHostileDocumentAreBounded) {
  std::string text = "{\"list\": [0" + std::string(10'000, ' ') + ",[1,2,3]]";
  for (int k = 1; k < max_fields; ++k) text += ",\"" + std::string(1000, 'k') + std::to_string(k) + "\":0";
  const auto document = parse_json(text + "}", "f");
  ASSERT_TRUE(document) << document.error().text();
  const auto refused = parse_json(text + ",\"more\":0}", "f");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().problems[0].code, ErrorCode::range);
  std::string list = "[0";
  for (int k = 0; k < 2 * max_fields; ++k) list += ",0";
  EXPECT_TRUE(parse_json(list + "]", "f")) << "the length of a list is not limited";
  Error problems;
  Fields(*document, "f", problems).refuse_others();
  EXPECT_EQ(problems.problems.size(), max_problems);
  EXPECT_LT(problems.text().size(), 50'000u);
  Fields(Json(3), "f:", problems).refuse_others();
}

TEST(Json, ErrorsThatQuoteInvalidUtf8AreValidJson) {
  Error error(ErrorCode::duplicate, "a.json:3", "Two links have the name \"\xFF\".", "Rename one.");
  const auto back = parse_json(to_text(error_json(error)), "error");
  ASSERT_TRUE(back);
  const Json& p = (*back)["problems"][0];
  EXPECT_EQ(p["code"], "duplicate");
  EXPECT_EQ(p["location"], "a.json:3");
  EXPECT_EQ(p["message"], "Two links have the name \"\xEF\xBF\xBD\".");
  EXPECT_EQ(p["remedy"], "Rename one.");
}

}  // namespace
}  // namespace ugoki::json
