// Tests of the whole service over real sockets. The interpreter's process runs a fake simulation.
#include "ugoki/studio/studio.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "../content/fixture.h"
#include "client.h"
#include "fake_simulation.h"
#include "page.h"
#include "studio_fixture.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/store/library.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Frame;
using test::Page;
using test::Reply;
using test::request;
using test::StudioTest;

TEST_F(StudioTest, HelloContainsTheWholeStateAndAFrameFollows) {
  Page p = page();
  const json hello = p.ask({{"op", "hello"}});
  ASSERT_TRUE(hello["ok"]) << hello;
  EXPECT_EQ(hello["project"]["name"], "park.ugoki");
  EXPECT_EQ(hello["document"]["characters"][0]["id"], "human");
  json characters = hello["characters"];
  ASSERT_EQ(characters.size(), 2u);
  EXPECT_NEAR(characters[0]["end_speed"].get<double>(), 3 / 2.0 * 1.5, 0.01) << "3 m in 2 s, played 1.5 times as fast";
  EXPECT_EQ(characters[1]["end_speed"], 0);
  for (json& c : characters) c.erase("end_speed");
  EXPECT_EQ(characters, json::parse(R"([{"id":"human","name":"Human","mechanism":"m-walker","links":2},
                                        {"id":"ball","name":"Ball","mechanism":"m-ball","links":1}])"));
  EXPECT_FALSE(hello["can_undo"]);
  EXPECT_EQ(hello["transport"]["mode"], "edit");
  EXPECT_EQ(hello["transport"]["duration"], 8);
  EXPECT_TRUE(hello.contains("revision"));
  EXPECT_TRUE(p.frame(
      [](const Frame& f) { return f.characters.size() == 2 && f.characters[0].links.size() == 2 && f.characters[1].links.size() == 1; }));
  Page later = page();  // a new page gets the last frame even if nothing is playing
  ASSERT_TRUE(later.ask({{"op", "hello"}})["ok"]);
  EXPECT_TRUE(later.frame([](const Frame& f) { return f.characters.size() == 2; }));
}

TEST_F(StudioTest, ChoicesAreStoredAcrossRestarts) {
  const json choices = {{"keymap", "blender"}, {"theme", "light"}, {"view", {{"ghosts", true}}}};
  {
    Page p = page();
    EXPECT_EQ(p.ask({{"op", "hello"}})["choices"], json::object());
    ASSERT_TRUE(p.ask({{"op", "remember"}, {"choices", choices}})["ok"]);
    for (const json& wrong : {json(nullptr), json(3), json::array(), json{{"long", std::string(20'000, 'x')}}})
      EXPECT_FALSE(p.ask({{"op", "remember"}, {"choices", wrong}})["ok"]) << wrong;
    Page second = page();
    EXPECT_EQ(second.ask({{"op", "hello"}})["choices"], choices);
  }
  studio_.reset();
  start(project::Project::open(path()));
  EXPECT_EQ(page().ask({{"op", "hello"}})["choices"], choices);
  for (const char* damaged : {"", "{", "[1]", "\xff\xfe", "null"}) {
    std::ofstream(folder_ + "/choices.json", std::ios::binary) << damaged;
    EXPECT_EQ(page().ask({{"op", "hello"}})["choices"], json::object()) << damaged;
  }
}

TEST_F(StudioTest, CommandReachesAllPagesAndThePlayingContent) {
  Page a = page(), b = page();
  a.ask({{"op", "hello"}});
  b.ask({{"op", "hello"}});
  const json done = a.ask(move_clip(0.5));
  ASSERT_TRUE(done["ok"]) << done;
  for (Page* p : {&a, &b}) {
    const json document = p == &a ? a.events.back() : b.event("document");
    EXPECT_EQ(document["document"]["characters"][0]["track"][0]["start"], 0.5);
    EXPECT_TRUE(document["can_undo"]);
    EXPECT_TRUE(document["unsaved"]);
    EXPECT_EQ(document["revision"], done["revision"]);
    EXPECT_TRUE(p->frame([](const Frame& f) { return f.characters[0].links[0][0] == 0.5f; }));
  }
  a.frames.clear();
  const json undone = b.ask({{"op", "undo"}});
  ASSERT_TRUE(undone["ok"]);
  EXPECT_EQ(a.event("document")["document"]["characters"][0]["track"][0]["start"], 0);
  EXPECT_TRUE(a.frame([](const Frame& f) { return f.characters[0].links[0][0] == 0; }));
  EXPECT_FALSE(b.ask({{"op", "undo"}})["ok"]);
  ASSERT_TRUE(a.ask({{"op", "redo"}})["ok"]);
  ASSERT_TRUE(a.ask({{"op", "save"}})["ok"]);
  EXPECT_FALSE(a.events.back()["unsaved"]);
}

TEST_F(StudioTest, CommandsLoadMotionsFromTheLibrary) {
  Page p = page();
  const json done =
      p.ask({{"op", "command"}, {"command", {{"type", "clip.add"}, {"character", "human"}, {"motion", library_motion_}, {"start", 6.5}}}});
  ASSERT_TRUE(done["ok"]) << done;
  EXPECT_EQ(done["created"].size(), 1u);
  EXPECT_FALSE(
      p.ask({{"op", "command"}, {"command", {{"type", "clip.add"}, {"character", "human"}, {"motion", "n-0123"}, {"start", 1}}}})["ok"]);
}

TEST_F(StudioTest, MotionOperationIsAnsweredIfTheProjectIsClosed) {
  Page p = page(), other = page();
  const int request = p.post({{"op", "motion"}, {"task", "t1"}, {"character", "human"}, {"clip", "k1"}, {"operation", "reverse"}});
  ASSERT_TRUE(other.ask({{"op", "new"}, {"path", "another"}, {"from", "empty"}})["ok"]);
  const json reply = p.reply(request);
  ASSERT_FALSE(reply.is_null()) << "the page would wait for ever";
  // The operation may have ended before the project was closed.
  if (!reply["ok"]) EXPECT_NE(reply["error"]["problems"][0]["message"].get<std::string>().find("was closed"), std::string::npos) << reply;
}

TEST_F(StudioTest, NamesOfHiddenFilesAreRefused) {
  Page p = page();
  for (const char* name : {".", "/", "..", "folder/.", ".hidden"}) {
    EXPECT_FALSE(p.ask({{"op", "save"}, {"path", name}})["ok"]) << name;
    EXPECT_FALSE(p.ask({{"op", "new"}, {"path", name}, {"from", "empty"}})["ok"]) << name;
  }
}

TEST_F(StudioTest, MotionOperationIsOneUndoStep) {
  Page p = page();
  const json before = p.ask({{"op", "hello"}})["document"];
  const json ask = {{"op", "motion"}, {"task", "t1"}, {"character", "human"}, {"clip", "k1"}, {"operation", "reverse"}};
  const json done = p.ask(ask);
  ASSERT_TRUE(done["ok"]) << done;
  EXPECT_EQ(done["clip"], "k1");
  const json clip = p.ask({{"op", "hello"}})["document"]["characters"][0]["track"][0];
  EXPECT_EQ(clip["motion"], done["motion"]);
  EXPECT_NE(clip["motion"], before["characters"][0]["track"][0]["motion"]);
  EXPECT_EQ(p.ask({{"op", "hello"}})["undo_label"], "Reverse motion");
  const std::string id = done["motion"].get<std::string>();
  EXPECT_EQ(json::parse(api("GET", "/api/entry/" + id).body)["name"], "walk, reversed");
  EXPECT_NE(api("GET", "/api/library").body.find(id), std::string::npos) << "the list must contain the new motion of the project";
  EXPECT_EQ(api("GET", "/api/motion/" + id).status, 200);
  const json contacts = json::parse(api("GET", "/api/contacts/" + id).body);
  EXPECT_EQ(contacts["id"], id);
  EXPECT_TRUE(contacts["bands"].is_array());
  EXPECT_EQ(api("GET", "/api/contacts/n-0123").status, 404);
  ASSERT_TRUE(p.ask({{"op", "undo"}})["ok"]);
  EXPECT_EQ(p.ask({{"op", "hello"}})["document"], before);
  EXPECT_EQ(api("GET", "/api/library").body.find(id), std::string::npos)
      << "after the undo no clip uses the new motion, so it must not be listed";
  ASSERT_TRUE(p.ask({{"op", "redo"}})["ok"]);
  EXPECT_EQ(p.ask({{"op", "hello"}})["document"]["characters"][0]["track"][0]["motion"], done["motion"]);
  ASSERT_TRUE(p.ask({{"op", "command"}, {"command", {{"type", "clip.remove"}, {"character", "human"}, {"id", "k2"}}}})["ok"]);
  EXPECT_NE(api("GET", "/api/library").body.find("n-step"), std::string::npos)
      << "a motion that no operation made must be listed even if no clip uses it";
  ASSERT_TRUE(p.ask({{"op", "undo"}})["ok"]);

  json cancelled = ask;
  cancelled["id"] = 900;
  p.socket().send_text(cancelled.dump());
  EXPECT_TRUE(p.ask({{"op", "motion.cancel"}, {"task", "t1"}})["ok"]);
  EXPECT_TRUE(p.ask({{"op", "motion.cancel"}, {"task", "no such task"}})["ok"]);
  for (const auto& [key, value] :
       {std::pair<const char*, json>("task", ""), {"character", "nobody"}, {"clip", "k99"}, {"operation", "dance"}}) {
    json wrong = ask;
    wrong[key] = value;
    EXPECT_FALSE(p.ask(wrong)["ok"]) << key;
  }
  for (const char* operation : {"mix", "layer", "blend", "retarget", "join"}) {
    json wrong = ask;
    wrong["operation"] = operation;
    wrong["clip"] = before["characters"][0]["track"].back()["id"];
    const json refused = p.ask(wrong);
    EXPECT_FALSE(refused["ok"]) << operation << " must be rejected without its additional input";
    EXPECT_NE(refused["error"]["problems"][0]["remedy"], "") << refused;
  }
}

TEST_F(StudioTest, InvalidMessagesAreAnsweredWithProblems) {
  Page p = page();
  p.ask({{"op", "hello"}});
  const std::string document = p.ask({{"op", "hello"}})["document"].dump();
  for (const char* text : {"", "null", "[]", "{", "\"hello\"", "12", "{\"op\":\"hello\""}) {
    p.socket().send_text(text);
    const json r = p.reply(nullptr);
    ASSERT_TRUE(r.is_object()) << text;
    EXPECT_FALSE(r["ok"]);
    EXPECT_NE(r["error"]["problems"][0]["message"], "");
  }
  // The id of a message that cannot be used is repeated, if it is not ambiguous.
  const std::pair<const char*, json> with_id[] = {{R"({"id":1,"op":1e999})", 1},
                                                  {R"({"op":1e999,"id":2})", 2},
                                                  {R"({"op":"hello","op":"hello","id":"three"})", "three"},
                                                  {R"({"a":{"id":7},"id" : 4,"b":["id"],"c":"id","d":1,"d":2})", 4},
                                                  {R"({"id":5,"op":"hello")", 5},
                                                  {R"({"id":6,"id":6,"op":"hello"})", nullptr},
                                                  {R"({"id":[1],"op":1e999})", nullptr},
                                                  {R"({"a":{"id":7},"op":1e999})", nullptr}};
  for (const auto& [text, id] : with_id) {
    p.socket().send_text(text);
    const json r = p.reply(id);
    ASSERT_TRUE(r.is_object()) << text;
    EXPECT_FALSE(r["ok"]) << text;
    EXPECT_TRUE(r["error"]["problems"][0]["location"].get<std::string>().starts_with("message")) << r;
  }
  p.socket().send_text(std::string(1'000'000, '['));
  EXPECT_FALSE(p.reply(nullptr)["ok"]);
  p.socket().send_text(R"({"id":[1],"op":"hello"})");
  EXPECT_TRUE(p.reply(nullptr)["ok"]);
  p.socket().send_text(R"({"id":"text","op":"hello"})");
  EXPECT_TRUE(p.reply("text")["ok"]);
  const char* bad[] = {R"({})",
                       R"({"op":7})",
                       R"({"op":"nonsense"})",
                       R"({"op":"command"})",
                       R"({"op":"command","command":[]})",
                       R"({"op":"command","command":{}})",
                       R"({"op":"command","command":{"type":"clip.set","character":"human","id":"nothing","start":1}})",
                       R"({"op":"command","command":{"type":"clip.set","character":"human","id":"k1","start":"x"}})",
                       R"({"op":"command","command":{"type":"clip.set","character":"human","id":"k1","speed":-1}})",
                       R"({"op":"mode"})",
                       R"({"op":"mode","mode":"dream"})",
                       R"({"op":"play","speed":"fast"})",
                       R"({"op":"play","speed":1000})",
                       R"({"op":"step"})",
                       R"({"op":"step","frames":7})",
                       R"({"op":"seek"})",
                       R"({"op":"seek","time":null})",
                       R"({"op":"grab"})",
                       R"({"op":"grab","character":"human","link":0,"point":[0,0],"target":[0,0,0]})",
                       R"({"op":"grab","character":"human","link":{},"point":[0,0,0],"target":[0,0,0]})",
                       R"({"op":"grab","character":"human","link":0,"point":[0,0,0],"target":[0,0,0]})",  // the mode is not Simulate
                       R"({"op":"drag","target":["a",0,0]})",
                       R"({"op":"push","character":"human","link":0,"force":[1,2,3]})",
                       R"({"op":"save","path":7})",
                       R"({"op":"save","path":""})",
                       R"({"op":"save","path":"/nonexistent/folder/a.ugoki"})"};
  int id = 1000;
  for (const char* text : bad) {
    json message = json::parse(text);
    message["id"] = ++id;
    p.socket().send_text(message.dump());
    const json r = p.reply(id);
    ASSERT_TRUE(r.is_object()) << text;
    EXPECT_FALSE(r["ok"]) << text;
    EXPECT_NE(r["error"]["problems"][0]["location"], "") << text;
    EXPECT_NE(r["error"]["problems"][0]["message"], "") << text;
  }
  EXPECT_EQ(p.ask({{"op", "hello"}})["document"].dump(), document);
}

TEST_F(StudioTest, ModesOfOtherTypesAreRefused) {
  Page p = page();
  for (const json& wrong : {json(7), json(nullptr), json::array(), json::object(), json("fly")}) {
    const json refused = p.ask({{"op", "mode"}, {"mode", wrong}});
    EXPECT_EQ(refused["ok"], false) << wrong;
    EXPECT_EQ(refused["error"]["problems"][0]["code"], "syntax") << refused;
  }
}

TEST_F(StudioTest, ValuesOutOfRangeAreRefusedWithTheirLocation) {
  for (const auto& [target, location] : {std::pair{"height=-1", "height"},
                                         {"height=1e9", "height"},
                                         {"height=nan", "height"},
                                         {"height=inf", "height"},
                                         {"height=tall", "height"},
                                         {"height=0", "height"}}) {
    const Reply r = api("GET", std::string("/api/reference-character?") + target);
    EXPECT_EQ(r.status, 400) << target;
    EXPECT_EQ(json::parse(r.body)["error"]["problems"][0]["location"], location) << target;
  }
  EXPECT_EQ(api("GET", "/api/reference-character").status, 200);
  EXPECT_EQ(api("GET", "/api/reference-character?height=1.2").status, 200);
  for (const auto& [target, location] : {std::pair{"limit=0", "limit"},
                                         {"limit=501", "limit"},
                                         {"limit=nan", "limit"},
                                         {"limit=-3", "limit"},
                                         {"limit=x", "limit"},
                                         {"limit=1.5", "limit"},
                                         {"removed=2", "removed"}}) {
    const Reply r = api("GET", std::string("/api/library?") + target);
    EXPECT_EQ(r.status, 400) << target;
    EXPECT_EQ(json::parse(r.body)["error"]["problems"][0]["location"], location) << target;
  }
  EXPECT_EQ(api("GET", "/api/library?limit=500&removed=0").status, 200);
  for (const auto& [target, location] : {std::pair{"unit=-1", "unit"},
                                         {"unit=0", "unit"},
                                         {"unit=nan", "unit"},
                                         {"unit=1e300", "unit"},
                                         {"rate=-5", "rate"},
                                         {"rate=inf", "rate"},
                                         {"rate=fast", "rate"}}) {
    const Reply r = api("POST", std::string("/api/import/stage?name=a.bvh&") + target, "x");
    EXPECT_EQ(r.status, 400) << target;
    EXPECT_EQ(json::parse(r.body)["error"]["problems"][0]["location"], location) << target;
  }
  Page p = page();
  p.ask({{"op", "hello"}});
  ASSERT_TRUE(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  int id = 2000;
  for (const auto& [text, location] : {std::pair{R"("op":"seek","time":-1)", "time"},
                                       {R"("op":"seek","time":8.5)", "time"},
                                       {R"("op":"play","speed":0)", "speed"},
                                       {R"("op":"play","speed":-1)", "speed"},
                                       {R"("op":"play","speed":100)", "speed"},
                                       {R"("op":"push","character":"human","link":0,"force":[1e9,0,0],"duration":1)", "force"},
                                       {R"("op":"push","character":"human","link":0,"force":[1,0,0],"duration":-1)", "duration"},
                                       {R"("op":"grab","character":"human","link":0,"point":[0,0,0],"target":[1e20,0,0])", "target"},
                                       {R"("op":"grab","character":"human","link":-1,"point":[0,0,0],"target":[0,0,0])", "link"},
                                       {R"("op":"grab","character":"human","link":99,"point":[0,0,0],"target":[0,0,0])", "link"}}) {
    p.socket().send_text("{\"id\":" + std::to_string(++id) + "," + text + "}");
    const json r = p.reply(id);
    ASSERT_TRUE(r.is_object()) << text;
    EXPECT_FALSE(r["ok"]) << text;
    EXPECT_EQ(r["error"]["problems"][0]["location"], location) << text;
  }
  EXPECT_TRUE(p.ask({{"op", "seek"}, {"time", 0}})["ok"]);
  EXPECT_EQ(p.ask({{"op", "hello"}})["transport"]["speed"], 1) << "a refused speed changes nothing";
}

TEST_F(StudioTest, TransportPlaysPausesStepsAndSeeks) {
  Page p = page();
  p.ask({{"op", "hello"}});
  ASSERT_TRUE(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  p.frames.clear();
  ASSERT_TRUE(p.ask({{"op", "play"}})["ok"]);
  EXPECT_TRUE(p.frame([](const Frame& f) { return f.time >= 1.2; }));
  ASSERT_TRUE(p.ask({{"op", "pause"}})["ok"]);
  const auto playing = std::ranges::count_if(p.frames, [](const Frame& f) { return (f.flags & content::frame_playing) != 0; });
  EXPECT_GE(playing, 60);  // 1.2 s of content; at least 50 frames a second
  EXPECT_TRUE(std::ranges::any_of(
      p.events, [](const json& e) { return e["event"] == "transport" && e["playing"] == true && e["realtime_factor"] > 0; }));
  EXPECT_TRUE(std::ranges::any_of(
      p.events, [](const json& e) { return e["event"] == "summary" && e["characters"].size() == 2 && !e["contacts"].empty(); }));
  ASSERT_TRUE(p.ask({{"op", "seek"}, {"time", 0.5}})["ok"]);
  EXPECT_EQ(p.frames.back().number, 30u);
  ASSERT_TRUE(p.ask({{"op", "step"}, {"frames", 1}})["ok"]);
  EXPECT_EQ(p.frames.back().number, 31u);
  ASSERT_TRUE(p.ask({{"op", "step"}, {"frames", -1}})["ok"]);
  EXPECT_EQ(p.frames.back().number, 30u);
  ASSERT_TRUE(p.ask({{"op", "grab"}, {"character", "human"}, {"link", 1}, {"point", {0, 0, 0}}, {"target", {-2, 0, 1}}})["ok"]);
  EXPECT_NE(p.frames.back().flags & content::frame_grab, 0u);
  p.socket().send_text(R"({"id":5000,"op":"drag","target":[-3,0,1]})");  // is not answered
  ASSERT_TRUE(p.ask({{"op", "release"}})["ok"]);
  EXPECT_FALSE(std::ranges::any_of(p.events, [](const json& e) { return e.contains("reply"); }));
  EXPECT_EQ(p.frames.back().flags & content::frame_grab, 0u);
  ASSERT_TRUE(p.ask({{"op", "push"}, {"character", "human"}, {"link", 0}, {"force", {150, 0, 0}}, {"duration", 0.2}})["ok"]);
  ASSERT_TRUE(p.ask({{"op", "restart"}})["ok"]);
  EXPECT_EQ(p.frames.back().number, 0u);
}

TEST_F(StudioTest, KilledInterpreterKeepsProjectAndRestartsOnPlay) {
  Page p = page();
  p.ask({{"op", "hello"}});
  ASSERT_TRUE(p.ask(move_clip(0.5))["ok"]);
  ASSERT_TRUE(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  ASSERT_TRUE(p.ask({{"op", "play"}})["ok"]);
  EXPECT_TRUE(p.frame([](const Frame& f) { return f.time >= 0.1; }));
  const int pid = studio_->interpreter_pid();
  ASSERT_GT(pid, 0);
  ASSERT_EQ(::kill(pid, SIGKILL), 0);
  const json stopped = p.event("stopped");
  EXPECT_NE(stopped["reason"].get<std::string>().find("signal 9"), std::string::npos) << stopped;
  EXPECT_EQ(p.event("transport")["playing"], false);
  ASSERT_TRUE(p.ask(move_clip(0.75))["ok"]);  // editing works without an interpreter
  ASSERT_TRUE(p.ask({{"op", "pause"}})["ok"]);
  ASSERT_TRUE(p.ask({{"op", "play"}})["ok"]);
  EXPECT_NE(studio_->interpreter_pid(), pid);
  p.frames.clear();
  EXPECT_TRUE(p.frame([](const Frame& f) { return f.time >= 0.1 && (f.flags & content::frame_simulate) != 0; }));
  EXPECT_EQ(p.ask({{"op", "hello"}})["document"]["characters"][0]["track"][0]["start"], 0.75);
}

TEST_F(StudioTest, CrashAndFailedStepAreReportedAndCanBeFixed) {
  Page p = page();
  p.ask({{"op", "hello"}});
  ASSERT_TRUE(p.ask(rename(R"({"crash":0.1})"))["ok"]);
  ASSERT_TRUE(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  p.socket().send_text(R"({"id":1,"op":"play"})");
  EXPECT_NE(p.event("stopped")["reason"].get<std::string>().find("Stopped at t = 0."), std::string::npos);
  ASSERT_TRUE(p.ask(rename(R"({"blow_up":0.2})"))["ok"]);
  ASSERT_TRUE(p.ask({{"op", "play"}})["ok"]);
  EXPECT_NE(p.event("stopped")["reason"].get<std::string>().find("joint hip"), std::string::npos);
  ASSERT_TRUE(p.ask(rename("calm"))["ok"]);
  ASSERT_TRUE(p.ask({{"op", "play"}})["ok"]);
  p.frames.clear();
  EXPECT_TRUE(p.frame([](const Frame& f) { return f.time >= 0.5; }));
}

TEST_F(StudioTest, LibraryListsSearchesAndDrawsEntries) {
  const auto entries = [&](const std::string& target) {
    const Reply r = api("GET", target);
    EXPECT_EQ(r.status, 200) << r.body;
    return json::parse(r.body)["entries"];
  };
  const json all = entries("/api/library?kind=&q=");
  EXPECT_EQ(all.size(), 6u) << all.dump(1);  // two entries of the library, two mechanisms and two motions of the project
  const json motions = entries("/api/library?kind=motion");
  EXPECT_EQ(motions.size(), 3u);
  const json run = entries("/api/library?kind=motion&q=ru%20quick");
  ASSERT_EQ(run.size(), 1u);
  EXPECT_EQ(run[0]["id"], library_motion_);
  EXPECT_EQ(run[0]["duration"], 1);
  EXPECT_EQ(run[0]["summary"], "1.00 s · 100 Hz");
  EXPECT_EQ(run[0]["mechanism"], library_mechanism_);
  EXPECT_GT(run[0]["curve"].size(), 10u);
  EXPECT_EQ(entries("/api/library?q=no-such-entry").size(), 0u);
  EXPECT_EQ(api("GET", "/api/library?kind=house").status, 400);

  for (const std::string& id : {std::string("m-walker"), library_mechanism_}) {
    const Reply r = api("GET", "/api/mechanism/" + id);
    ASSERT_EQ(r.status, 200) << r.body;
    const json m = json::parse(r.body);
    EXPECT_EQ(m["name"], "walker");
    EXPECT_EQ(m["dofs"], 7);
    EXPECT_NEAR(m["height"].get<double>(), 0.55, 1e-9);
    ASSERT_EQ(m["links"].size(), 2u);
    EXPECT_EQ(m["links"][1]["parent"], 0);
    EXPECT_EQ(m["links"][1]["joint"], "revolute");
    EXPECT_EQ(m["links"][1]["shapes"][0]["type"], "capsule");
    EXPECT_NEAR(m["links"][1]["shapes"][0]["half_length"].get<double>(), 0.2, 1e-12);
    EXPECT_EQ(m["links"][1]["shapes"][0]["pose"].size(), 7u);
    EXPECT_EQ(m["links"][1]["neutral"].size(), 7u);
  }
  EXPECT_EQ(api("GET", "/api/mechanism/m-0000").status, 404);
  EXPECT_EQ(api("GET", "/api/mechanism/..%2f..%2fetc").status, 404);
  EXPECT_EQ(api("GET", "/api/nothing").status, 404);
  EXPECT_EQ(api("POST", "/api/library").status, 404);
}

TEST_F(StudioTest, LibraryEntriesSupportVersionsConflictsTrashAndThumbnails) {
  Page p = page();
  p.ask({{"op", "hello"}});
  const std::string entry = "/api/entry/" + library_motion_;
  const auto post = [&](const std::string& path, const json& body) { return api("POST", path, body.dump()); };
  json now = json::parse(api("GET", entry).body);
  EXPECT_EQ(now["version"], 1);
  EXPECT_EQ(now["content"], library_motion_);
  EXPECT_EQ(now["versions"].size(), 1u);
  const std::string before = now["name"];

  const Reply renamed = post(entry, {{"base", 1}, {"name", "dash"}, {"note", "left knee"}, {"add_tags", {"quick"}}});
  ASSERT_EQ(renamed.status, 200) << renamed.body;
  EXPECT_EQ(json::parse(renamed.body)["entry"]["version"], 2);
  EXPECT_TRUE(p.event("library").is_object());
  const Reply conflict = post(entry, {{"base", 1}, {"name", "mine"}});
  EXPECT_EQ(conflict.status, 409);
  const json reported = json::parse(conflict.body);
  EXPECT_EQ(reported["error"]["problems"][0]["code"], "conflict");
  EXPECT_EQ(reported["entry"]["name"], "dash");
  EXPECT_EQ(reported["entry"]["version"], 2);
  for (const json& wrong :
       {json({{"name", "x"}}), json({{"base", 2}, {"nonsense", 1}}), json({{"base", 2}, {"add_tags", {7}}}), json::array()})
    EXPECT_EQ(post(entry, wrong).status / 100, 4) << wrong;
  EXPECT_EQ(api("POST", entry, "{").status, 400);
  EXPECT_EQ(post("/api/entry/n-none", {{"base", 1}, {"name", "x"}}).status, 404);

  const json found = json::parse(api("GET", "/api/library?q=knee&tag=quick&kind=motion").body);
  ASSERT_EQ(found["entries"].size(), 1u);
  EXPECT_EQ(found["total"], 1);
  EXPECT_TRUE(found["next"].is_null());
  const json tags = json::parse(api("GET", "/api/library/tags").body);
  EXPECT_NE(std::ranges::find(tags["tags"], json({{"name", "quick"}, {"count", 1}})), tags["tags"].end()) << tags;
  const json first = json::parse(api("GET", "/api/library?limit=1&order=newest").body);
  ASSERT_TRUE(first["next"].is_string()) << first;
  EXPECT_EQ(first["entries"][0]["id"], library_motion_);
  const json second = json::parse(api("GET", "/api/library?limit=1&order=newest&after=" + first["next"].get<std::string>()).body);
  EXPECT_EQ(second["entries"][0]["id"], library_mechanism_) << second;
  EXPECT_EQ(api("GET", "/api/library?after=nonsense").status, 400);
  EXPECT_EQ(api("GET", "/api/library?order=nonsense").status, 400);

  const Reply restored = post(entry + "/restore", {{"base", 2}, {"version", 1}});
  ASSERT_EQ(restored.status, 200) << restored.body;
  EXPECT_EQ(json::parse(restored.body)["entry"]["name"], before);
  const Reply copy = post(entry + "/duplicate", {{"name", "a copy"}});
  ASSERT_EQ(copy.status, 200) << copy.body;
  EXPECT_EQ(json::parse(copy.body)["entry"]["content"], library_motion_);

  EXPECT_EQ(api("GET", "/api/thumbnail/" + library_motion_).status, 404);
  EXPECT_EQ(api("POST", "/api/thumbnail/" + library_motion_, "GIF89a").status, 400);
  const std::string png = "\x89PNG\r\n\x1a\n and pixels";
  EXPECT_EQ(api("POST", "/api/thumbnail/" + library_motion_, png).status, 200);
  EXPECT_EQ(api("GET", "/api/thumbnail/" + library_motion_).body, png);

  EXPECT_EQ(api("POST", entry + "/remove").status, 200);
  EXPECT_EQ(api("POST", entry + "/remove").status, 404);
  EXPECT_NE(json::parse(api("GET", entry).body)["removed"], "");
  EXPECT_EQ(json::parse(api("GET", "/api/library?removed=1").body)["entries"].size(), 1u);
  EXPECT_EQ(api("POST", entry + "/undelete").status, 200);
  EXPECT_EQ(json::parse(api("GET", entry).body)["versions"].size(), 3u);
  EXPECT_EQ(api("POST", entry + "/explode").status, 404);
}

/// BVH file of a person with two joints who nods for three frames.
const char* const small_bvh =
    "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0 0\n  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    "  JOINT Spine\n  {\n    OFFSET 0 0.5 0\n    CHANNELS 3 Zrotation Xrotation Yrotation\n    End Site\n    {\n      OFFSET 0 0.7 0\n    "
    "}\n  }\n}\n"
    "MOTION\nFrames: 3\nFrame Time: 0.0083333\n0 1 0 0 0 0 0 0 0\n0 1 0 0 0 0 0 10 0\n0 1 0 0 0 0 0 20 0\n";

TEST_F(StudioTest, ImportStoresFilesOrLeavesTheLibraryUnchanged) {
  Page p = page();
  p.ask({{"op", "hello"}});
  const auto library = [&] { return api("GET", "/api/library").body; };
  const std::string before = library();
  const std::string whole = small_bvh;
  const std::pair<std::string, std::string> bad[] = {{"a.bvh", ""},
                                                     {"a.bvh", whole.substr(0, whole.size() / 2)},
                                                     {"a.bvh", std::string(5000, '\0')},
                                                     {"a.bvh", "HIERARCHY\nROOT x {"},
                                                     {"a.amc", ":DEGREES\n1\nroot 0 0 0 0 0 0\n"},
                                                     {"a.asf", ":version x"},
                                                     {"a.json", "{\"name\": 7}"},
                                                     {"a.exe", "MZ"},
                                                     {"", whole},
                                                     {"..%2f..%2fpasswd", whole}};
  for (const auto& [name, bytes] : bad) {
    const Reply r = api("POST", "/api/import?name=" + name, bytes);
    EXPECT_EQ(r.status / 100, 4) << name << r.body;
    const json problem = json::parse(r.body)["error"]["problems"][0];
    EXPECT_NE(problem["message"], "") << name;
    EXPECT_NE(problem["location"], "") << name;
    EXPECT_NE(problem["remedy"], "") << name;
  }
  EXPECT_EQ(library(), before);

  const Reply r = api("POST", "/api/import?name=nod.bvh", whole);
  ASSERT_EQ(r.status, 200) << r.body;
  const json entries = json::parse(r.body)["entries"];
  ASSERT_EQ(entries.size(), 2u) << r.body;
  EXPECT_FALSE(json::parse(r.body)["report"].empty());
  EXPECT_TRUE(p.event("library").is_object());
  const json motion = entries[0]["kind"] == "motion" ? entries[0] : entries[1];
  EXPECT_EQ(motion["name"], "nod");
  EXPECT_EQ(motion["frames"], 3);
  EXPECT_EQ(api("GET", "/api/mechanism/" + motion["mechanism"].get<std::string>()).status, 200);
  EXPECT_NE(library(), before);
  // The imported entries can be used immediately.
  const json added = p.ask({{"op", "command"}, {"command", {{"type", "character.add"}, {"mechanism", motion["mechanism"]}}}});
  ASSERT_TRUE(added["ok"]) << added;
  const json clip = p.ask(
      {{"op", "command"}, {"command", {{"type", "clip.add"}, {"character", added["created"][0]}, {"motion", motion["id"]}, {"start", 0}}}});
  EXPECT_TRUE(clip["ok"]) << clip;
}

TEST_F(StudioTest, StudioEndsItsInterpreterAndKeepsUnsavedWork) {
  int pid = -1;
  {
    Page p = page();
    p.ask({{"op", "hello"}});
    ASSERT_TRUE(p.ask(move_clip(0.25))["ok"]);
    ASSERT_TRUE(p.ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
    ASSERT_TRUE(p.ask({{"op", "play"}})["ok"]);
    pid = studio_->interpreter_pid();
    studio_.reset();
  }
  EXPECT_NE(::kill(pid, 0), 0);
  start(project::Project::open(path()));
  Page p = page();
  const json hello = p.ask({{"op", "hello"}});
  EXPECT_EQ(hello["document"]["characters"][0]["track"][0]["start"], 0.25);
  EXPECT_TRUE(hello["unsaved"]);
  EXPECT_TRUE(hello["can_undo"]);
}

}  // namespace
}  // namespace ugoki::studio
