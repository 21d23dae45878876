// modelDescription.xml: invalid descriptions, and how variables become pins and parameters.

#include "fmi_test.h"
#include "ugoki/fmi/declare.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki::fmi {
namespace {

/// Returns `text` with the first occurrence of `from` replaced by `to`. The test fails if `text` does not contain `from`.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}
/// Error text of read_model_description() for this XML; "read" if the XML is read without an error.
std::string reported(const std::string& xml) {
  const auto d = read_model_description(xml, "x.fmu/modelDescription.xml");
  return d ? "read" : d.error().text();
}

TEST(Description, InvalidDescriptionsAreRefusedWithReason) {
  const std::string good = description_of("bouncing_ball", 3), two = description_of("bouncing_ball", 2);
  EXPECT_EQ(reported(good), "read");
  EXPECT_EQ(reported(two), "read");
  const std::vector<std::pair<std::string, std::string>> cases{
      {replaced(good, "fmiVersion=\"3.0\"", "fmiVersion=\"3.0-beta.4\""), "FMI '3.0-beta.4'"},
      {replaced(two, "fmiVersion=\"2.0\"", "fmiVersion=\"1.0\""), "FMI '1.0'; only FMI 2.0 and 3.0 are supported"},
      {replaced(good, "<CoSimulation", "<ModelExchange"), "for model exchange only"},
      {replaced(good, "<CoSimulation", "<ScheduledExecution"), "for scheduled execution only"},
      {replaced(good, "modelIdentifier=\"BouncingBall\"", "modelIdentifier=\"../../evil\""), "not a C identifier"},
      {replaced(good, "instantiationToken", "guid"), "no instantiationToken"},
      {replaced(good, "name=\"v\"", "name=\"h\""), "Two variables are called 'h' and differ"},
      {replaced(good, "valueReference=\"3\"", "valueReference=\"1\""), "Two variables have the value reference 1"},
      {replaced(good, "valueReference=\"3\"", "valueReference=\"-3\""),
       "The value reference '-3' of the variable 'v' is not a whole number"},
      {replaced(good, "valueReference=\"3\"", "valueReference=\"99999999999\""), "'99999999999' of the variable 'v' is not a whole number"},
      {replaced(good, "valueReference=\"3\"", ""), "'v' has no value reference"},
      {replaced(good, "causality=\"parameter\"", "causality=\"perimeter\""), "unknown causality, 'perimeter'"},
      {replaced(good, "variability=\"tunable\"", "variability=\"tuneable\""), "unknown variability"},
      {replaced(good, "start=\"-9.81\"", "start=\"much\""), "not valid for its type: 'much'"},
      {replaced(good, "start=\"-9.81\"", "start=\"NaN\""), "not valid for its type: 'NaN'"},
      {replaced(good, "min=\"0.5\"", "min=\"5\""), "is above its maximum"},
      {replaced(good, "min=\"0.5\"", "min=\"few\""), "is not a number"},
      {replaced(good, "fixedInternalStepSize=\"1e-3\"", "fixedInternalStepSize=\"-1\""), "not a positive time"},
      {replaced(good, "declaredType=\"Position\"", "declaredType=\"Positron\""), "'Positron', which is not declared"},
      {replaced(good, "canGetAndSetFMUState=\"true\"", "canGetAndSetFMUState=\"perhaps\""), "neither true nor false"},
      {replaced(good, "<Float64 name=\"g\"",
                "<Clock name=\"c\" valueReference=\"90\" causality=\"input\" intervalVariability=\"triggered\"/><Float64 name=\"g\""),
       "The input 'c' is a clock"},
      {good.substr(0, good.size() / 2), "not valid XML"},
      {"", "not valid XML"},
      {"<a/>", "<fmiModelDescription> is missing"},
  };
  for (const auto& [xml, sentence] : cases)
    EXPECT_NE(reported(xml).find(sentence), std::string::npos) << reported(xml) << "\nexpected: " << sentence;
}

/// Text of the element that begins with `begin` and ends with `end`, which is included.
std::string element(const std::string& text, const std::string& begin, const std::string& end) {
  const auto at = text.find(begin);
  const auto stop = text.find(end, at);
  EXPECT_TRUE(at != std::string::npos && stop != std::string::npos) << begin;
  return at == std::string::npos || stop == std::string::npos ? "" : text.substr(at, stop + end.size() - at);
}
/// `text` with a copy of `element` inserted behind it.
std::string repeated(const std::string& text, const std::string& element) { return replaced(text, element, element + "\n" + element); }

TEST(Description, RepeatedDeclarationsAreReadOnceAndNoted) {
  const std::string two = description_of("feedthrough", 2), three = description_of("feedthrough", 3);
  for (const std::string& good : {two, three}) {
    const auto plain = read_model_description(good, "x");
    ASSERT_TRUE(plain) << plain.error().text();
    EXPECT_TRUE(plain->notes.empty());
    const bool is_two = plain->version == 2;
    const std::string variable = is_two ? element(good, "<ScalarVariable", "</ScalarVariable>") : element(good, "<Float64 ", "/>");
    const std::string item = element(good, "<Item", ">");
    for (const std::string& xml : {repeated(good, variable), repeated(good, item)}) {
      const auto d = read_model_description(xml, "x");
      ASSERT_TRUE(d) << d.error().text();
      EXPECT_EQ(d->variables.size(), plain->variables.size());
      ASSERT_EQ(d->enumerations.size(), plain->enumerations.size());
      EXPECT_EQ(d->enumerations[0].items, plain->enumerations[0].items);
      ASSERT_EQ(d->notes.size(), 1u);
      EXPECT_NE(d->notes[0].find("is read once"), std::string::npos) << d->notes[0];
      EXPECT_NE(declare(*d).notes.size(), declare(*plain).notes.size()) << "the note should reach the user";
    }
    // The same name with other content is refused.
    const std::string other = replaced(variable, "valueReference=\"0\"", "valueReference=\"991\"");
    EXPECT_NE(reported(replaced(good, variable, other + "\n" + variable)).find("are called 'time' and differ"), std::string::npos);
  }
  const std::string types =
      R"(<TypeDefinitions><SimpleType name="T"><Real unit="m"/></SimpleType><SimpleType name="T"><Real unit="UNIT"/></SimpleType></TypeDefinitions>)";
  const std::string with = replaced(description_of("dahlquist", 2), "<ModelVariables>", types + "<ModelVariables>");
  EXPECT_EQ(reported(replaced(with, "UNIT", "m")), "read");
  EXPECT_NE(reported(replaced(with, "UNIT", "kg")).find("Two types are called 'T' and differ"), std::string::npos);
}

TEST(Description, HostileXmlIsRefusedQuickly) {
  // Entities are not expanded, nesting is not read by recursion, and arrays have bounds.
  const std::string good = description_of("naughty", 3);
  std::string bomb = R"(<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>)";
  EXPECT_NE(reported(bomb + "<fmiModelDescription fmiVersion=\"&b;\"/>").find("FMI '&b;'"), std::string::npos);
  std::string deep;
  for (int i = 0; i < 1'000'000; ++i) deep += "<a>";
  EXPECT_NE(reported(deep).find("not valid XML"), std::string::npos);
  std::string closed = deep;
  for (int i = 0; i < 1'000'000; ++i) closed += "</a>";
  EXPECT_NE(reported(closed).find("<fmiModelDescription> is missing"), std::string::npos);
  EXPECT_NE(reported(replaced(good, "<Dimension start=\"3\"/>", "<Dimension start=\"4000000000\"/><Dimension start=\"4000000000\"/>"))
                .find("too large"),
            std::string::npos);
  EXPECT_NE(reported(replaced(good, "start=\"2\"", "start=\"1e300\"")).find("does not refer to a structural parameter"), std::string::npos);
  EXPECT_NE(reported(replaced(good, "<Dimension valueReference=\"7\"/>", "<Dimension valueReference=\"77\"/>"))
                .find("does not refer to a structural parameter"),
            std::string::npos);
  EXPECT_NE(reported(replaced(good, "start=\"0 0 0\"", "start=\"0 0\"")).find("2 start values for 3 elements"), std::string::npos);
}

TEST(Description, VariablesWithoutPinTypeAreNoted) {
  const auto d = read_model_description(description_of("feedthrough", 3), "x");
  ASSERT_TRUE(d) << d.error().text();
  const Declarations declared = declare(*d);
  ASSERT_EQ(declared.notes.size(), 1u);
  EXPECT_EQ(declared.notes[0],
            "'Binary_input', 'Binary_output' are binary values or clocks, for which there is no pin type; they are left out.");
  EXPECT_EQ(declared.classes.size(), 1u);
  const circuit::LsiClass& c = declared.classes[0].lsi_class;
  const circuit::Parameter& text = c.parameters[static_cast<std::size_t>(c.find_parameter("String_parameter"))];
  EXPECT_EQ(text.kind, circuit::ParameterKind::text);
  EXPECT_EQ(std::get<std::string>(text.initial), "Set me!");
}

TEST(Description, EnumerationParametersAreChoices) {
  const std::string xml = R"(<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t"><CoSimulation modelIdentifier="m"/>
    <TypeDefinitions><EnumerationType name="Mode"><Item name="off" value="-1"/><Item name="on" value="4"/></EnumerationType></TypeDefinitions>
    <ModelVariables><Enumeration name="a.mode" valueReference="1" causality="parameter" variability="tunable" declaredType="Mode" start="4"/>
    <Float64 name="a:mode" valueReference="2" causality="parameter" variability="fixed" start="1" min="-INF" max="2" unit="rad" displayUnit="deg" description="Angle"/>
    <Int8 name="n" valueReference="3" causality="parameter" variability="fixed" start="5"/></ModelVariables></fmiModelDescription>)";
  const auto d = read_model_description(xml, "x");
  ASSERT_TRUE(d) << d.error().text();
  const Declaration declared = declare(*d).classes[0];
  const auto& p = declared.lsi_class.parameters;
  EXPECT_EQ(p[0].name, "a:mode");
  EXPECT_EQ(p[0].kind, circuit::ParameterKind::choice);
  EXPECT_EQ(std::get<std::string>(p[0].initial), "on");
  EXPECT_EQ(declared.parameters[0].choices, (std::vector<std::int64_t>{-1, 4}));
  EXPECT_EQ(p[1].name, "a:mode'");
  EXPECT_EQ(p[1].maximum, 2);
  EXPECT_EQ(p[1].minimum, -1e300);
  EXPECT_EQ(p[1].doc, "Angle (often shown in deg)");
  EXPECT_EQ(p[2].kind, circuit::ParameterKind::integer);
  EXPECT_EQ(p[3].name, "logging");
}

}  // namespace
}  // namespace ugoki::fmi
