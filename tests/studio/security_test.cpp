#include "ugoki/studio/security.h"

#include <gtest/gtest.h>

#include <set>

namespace ugoki::studio {
namespace {

TEST(Security, TokensAreLongAndUnique) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string token = make_token();
    EXPECT_EQ(token.size(), 43u);
    EXPECT_EQ(token.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_"), std::string::npos);
    seen.insert(token);
  }
  EXPECT_EQ(seen.size(), 1000u);
}

TEST(Security, SecretsAreComparedCompletely) {
  EXPECT_TRUE(equal_secret("abc", "abc"));
  EXPECT_FALSE(equal_secret("abd", "abc"));
  EXPECT_FALSE(equal_secret("ab", "abc"));
  EXPECT_FALSE(equal_secret("abcabc", "abc"));
  EXPECT_FALSE(equal_secret("", "abc"));
  EXPECT_FALSE(equal_secret("", ""));
}

TEST(Security, FindsTokenInHeaders) {
  EXPECT_EQ(bearer_token("Bearer x"), "x");
  EXPECT_EQ(bearer_token("bearer  x "), "x");
  EXPECT_FALSE(bearer_token("Bearer"));
  EXPECT_FALSE(bearer_token("Basic x"));
  EXPECT_FALSE(bearer_token(""));
  EXPECT_EQ(subprotocol_token("ugoki, ugoki.token.x"), "x");
  EXPECT_EQ(subprotocol_token("ugoki.token.,ugoki"), "");
  EXPECT_FALSE(subprotocol_token("ugoki"));
  EXPECT_FALSE(subprotocol_token(",,;"));
  EXPECT_TRUE(offers_subprotocol("a, ugoki"));
  EXPECT_FALSE(offers_subprotocol("ugoki.token.x"));
}

TEST(Security, DecodesTargetsAndQueries) {
  EXPECT_EQ(percent_decoded("/a%20b%2Fc"), "/a b/c");
  EXPECT_FALSE(percent_decoded("/a%2"));
  EXPECT_FALSE(percent_decoded("/a%zz"));
  EXPECT_FALSE(percent_decoded("/a%00b"));
  const std::optional<Target> t = parse_target("/api/x%41?q=a%20b+c&kind=");
  ASSERT_TRUE(t);
  EXPECT_EQ(t->path, "/api/xA");
  EXPECT_EQ(query_value(t->query, "q"), "a b c");
  EXPECT_EQ(query_value(t->query, "kind"), "");
  EXPECT_FALSE(query_value(t->query, "z"));
  EXPECT_FALSE(parse_target("http://127.0.0.1/"));
  EXPECT_FALSE(parse_target(""));
  EXPECT_FALSE(parse_target("*"));
}

TEST(Security, RejectsPathsOutsideTheWebFolder) {
  for (const char* good : {"/", "/index.html", "/assets/a.js", "/a..b/c...d", "/.hidden"}) EXPECT_TRUE(is_plain_path(good)) << good;
  for (const char* bad : {"", "a", "/..", "/../etc/passwd", "/a/../../b", "/./a", "/a\\..\\b", "/a\nb"})
    EXPECT_FALSE(is_plain_path(bad)) << bad;
}

TEST(Security, GateFollowsTheProtocol) {
  const Gate gate{4711, "secret", "code"};
  Credentials c{"127.0.0.1:4711", 1, std::nullopt, 0, "", "", ""};
  for (const char* open : {"/", "/index.html", "/assets/index.js", "/api/session"}) {
    c.path = open;
    EXPECT_EQ(gate.admit(c), Admission::open) << open;
  }
  for (const char* guarded : {"/ws", "/api/library", "/api", "/api/session/x"}) {
    c.path = guarded;
    c.authorization = "";
    EXPECT_EQ(gate.admit(c), Admission::no_token) << guarded;
    for (const char* wrong : {"Bearer wrong", "Bearer code", "Bearer "}) {
      c.authorization = wrong;
      EXPECT_NE(gate.admit(c), Admission::granted) << guarded;
    }
    c.authorization = "Bearer secret";
    EXPECT_EQ(gate.admit(c), Admission::granted) << guarded;
  }
  c.authorization = "";
  c.subprotocols = "ugoki, ugoki.token.secret";
  c.path = "/api/library";
  EXPECT_EQ(gate.admit(c), Admission::no_token);
  c.path = "/ws";
  EXPECT_EQ(gate.admit(c), Admission::granted);
  c.subprotocols = "ugoki, ugoki.token.wrong";
  EXPECT_EQ(gate.admit(c), Admission::wrong_token);
  c.path = "/assets/index.js";
  for (const char* host : {"localhost:4711", "127.0.0.1", "127.0.0.1:4712", "evil.example:4711", "", "127.0.0.1:4711.evil.example"}) {
    c.host = host;
    EXPECT_EQ(gate.admit(c), Admission::bad_host) << host;
  }
  c.host = "127.0.0.1:4711";
  c.host_count = 2;
  EXPECT_EQ(gate.admit(c), Admission::bad_host);
  c.host_count = 1;
  for (const char* origin :
       {"http://localhost:4711", "https://127.0.0.1:4711", "null", "", "http://127.0.0.1:4712", "http://evil.example"}) {
    c.origin = origin;
    EXPECT_EQ(gate.admit(c), Admission::bad_origin) << origin;
  }
  c.origin = "http://127.0.0.1:4711";
  EXPECT_EQ(gate.admit(c), Admission::open);
  c.origin_count = 2;
  EXPECT_EQ(gate.admit(c), Admission::bad_origin);
}

}  // namespace
}  // namespace ugoki::studio
