// The LSI builder's reader of declarations and annotations.

#include "ugoki/plugin/source.h"

#include <gtest/gtest.h>

#include "ugoki/plugin/comment.h"

namespace ugoki::plugin {
namespace {

TEST(Source, ReadsFunctionsAndTheirParameters) {
  const CSource s = read_source(R"(
#include <math.h>
#define TWICE(x) \
  ((x) + (x))
static double help(double x) { return x; }
double declared(double x);
double twice(double x) { return "}"[0] == '{' ? 2 * x : x + x; }
void parts(const double v[3], double *length, float out[4]) { }
unsigned long int count(int n, bool on) { return 1; }
int main(void) { return 0; }
)",
                                false);
  ASSERT_EQ(s.functions.size(), 4u);
  EXPECT_TRUE(s.functions[0].is_static);
  EXPECT_EQ(s.functions[1].name, "twice");
  EXPECT_EQ(s.functions[1].line, 7);
  const CFunction& parts = s.functions[2];
  ASSERT_EQ(parts.parameters.size(), 3u);
  EXPECT_TRUE(parts.parameters[0].type.is_const);
  EXPECT_EQ(parts.parameters[0].type.elements, 3);
  EXPECT_EQ(parts.parameters[1].type.pointers, 1);
  EXPECT_EQ(parts.parameters[1].name, "length");
  EXPECT_EQ(parts.parameters[2].type.base, "float");
  EXPECT_EQ(parts.parameters[2].type.elements, 4);
  EXPECT_EQ(s.functions[3].result.base, "unsigned long int");
  EXPECT_TRUE(s.functions[3].result.numeric());
}

TEST(Source, ReadsStructsOfBothLanguages) {
  const CSource c = read_source(
      "struct a { double x, y[2]; int n; };\ntypedef struct { double z; /* [m] = 2 how far */ } b;\nstruct p { char* text; };", false);
  ASSERT_EQ(c.structs.size(), 3u);
  EXPECT_EQ(c.find_struct("struct a")->fields.size(), 3u);
  EXPECT_EQ(c.find_struct("struct a")->fields[1].type.elements, 2);
  EXPECT_EQ(c.find_struct("struct a")->fields[1].type.base, "double");
  ASSERT_NE(c.find_struct("b"), nullptr);
  EXPECT_NE(c.find_struct("b")->fields[0].comment.find("how far"), std::string::npos);
  EXPECT_FALSE(c.find_struct("struct p")->understood);
  const CSource cpp = read_source(
      "namespace n {\nstruct S { double x = 3; void f() { x = 1; } int k{4}; };\ndouble g(S& s, double& out) { return out = s.x; }\n}",
      true);
  ASSERT_EQ(cpp.structs.size(), 1u);
  EXPECT_EQ(cpp.structs[0].fields.size(), 2u);
  EXPECT_EQ(cpp.structs[0].fields[0].initial, "3");
  ASSERT_EQ(cpp.functions.size(), 1u);
  EXPECT_EQ(cpp.functions[0].name, "n::g");
  EXPECT_TRUE(cpp.functions[0].parameters[0].type.reference);
}

TEST(Source, ReadsAnnotations) {
  const Annotation a = read_annotation("in x: vector [N m] = 1.5, -2..3e2 How far it is.");
  EXPECT_EQ(a.name, "x");
  EXPECT_EQ(a.type, "vector");
  EXPECT_EQ(a.unit, "N m");
  EXPECT_TRUE(a.has_value && a.has_range);
  EXPECT_EQ(a.value, 1.5);
  EXPECT_EQ(a.minimum, -2);
  EXPECT_EQ(a.maximum, 300);
  EXPECT_EQ(a.doc, "How far it is.");
  const Annotation b = read_annotation("parameter mode = cubic {linear, cubic} How it goes.");
  EXPECT_EQ(b.choices, (std::vector<std::string>{"linear", "cubic"}));
  EXPECT_EQ(b.word_value, "cubic");
  EXPECT_EQ(b.doc, "How it goes.");
  const Annotation c = read_annotation("param[in] x 2 is the usual number.");
  EXPECT_EQ(c.name, "x");
  EXPECT_EQ(c.doc, "2 is the usual number.");
  EXPECT_FALSE(c.has_range);
  const CSource s = read_source(
      "/**\n * Doubles.\n * @in x [m] What is\n *   doubled.\n * @return y [m]\n */\ndouble twice(double x) { return x; }\n\n// far "
      "away\n\n\ndouble plain(double x) { return x; }",
      false);
  ASSERT_EQ(s.functions.size(), 2u);
  EXPECT_EQ(s.functions[0].comment.doc, "Doubles.");
  ASSERT_NE(s.functions[0].comment.find("in", "x"), nullptr);
  EXPECT_EQ(s.functions[0].comment.find("in", "x")->doc, "What is doubled.");
  EXPECT_EQ(s.functions[0].comment.find("return")->name, "y");
  EXPECT_EQ(s.functions[1].comment.doc, "");
}

TEST(Source, InvalidProgramsAreAccepted) {
  const std::string text =
      "namespace a { struct { double x } f(((( \"unfinished /* } ) ] double g(double x) { extern \"C\" { template <class T> '";
  for (std::size_t n = 0; n <= text.size(); ++n)
    for (const bool cpp : {false, true}) (void)read_source(text.substr(0, n), cpp);
}

}  // namespace
}  // namespace ugoki::plugin
