// Full-text search: how texts are split into words, and that both databases give the same results.

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

#include "on_both.h"
#include "ugoki/store/library_body.h"
#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

using Words = std::vector<std::string>;

TEST(WordsTest, TextsAreSplitIntoFoldedWords) {
  EXPECT_EQ(words_of("12_01 Walk"), (Words{"12", "01", "walk"}));
  EXPECT_EQ(words_of("cmu-12_01.bvh"), (Words{"cmu", "12", "01", "bvh"}));
  EXPECT_EQ(words_of("Läufer LÄUFER la\xcc\x88ufer Ｗａｌｋ２"), (Words{"laufer", "laufer", "laufer", "walk2"}));
  EXPECT_EQ(words_of("Straße ŁÓDŹ İstanbul"), (Words{"strasse", "łodz", "istanbul"}));
  EXPECT_EQ(words_of("二足歩行テスト"), (Words{"二", "足", "歩", "行", "テ", "ス", "ト"}));
  EXPECT_EQ(words_of("ｶﾞﾝﾀﾞﾑ"), (Words{"ガ", "ン", "ダ", "ム"})) << "voicing marks are kept";
  EXPECT_EQ(words_of("ходьба бег"), (Words{"ходьба", "бег"}));
  EXPECT_EQ(words_of("हिन्दी"), (Words{"हिन्दी"}));
  EXPECT_EQ(words_of("걷기 연습"), (Words{"걷기", "연습"}));
  EXPECT_TRUE(words_of(" _-+%\"'\\ 🙂").empty());
  EXPECT_TRUE(words_of("\xff\xfe\x80").empty());
  EXPECT_EQ(words_of(std::string(1000, 'a')).front().size(), max_word_size - 3);
  EXPECT_EQ(name_key("Slow_Walk (2)"), "slow walk 2");
  EXPECT_EQ(clean_text("a\x01 b\xff c\n"), "a b\xef\xbf\xbd c\n");
}

TEST(WordsTest, SearchTextIsSplitIntoPhrases) {
  const SearchPhrases p = search_phrases("  12_01  \"slow walk\" % ");
  EXPECT_EQ(p.phrases, (std::vector<Words>{{"12", "01"}, {"slow", "walk"}}));
  EXPECT_EQ(p.key, "12 01 slow walk");
  EXPECT_FALSE(p.nothing);
  EXPECT_TRUE(search_phrases("% --").nothing);
  EXPECT_FALSE(search_phrases("  ").nothing);
  EXPECT_EQ(search_phrases("\"never closed").phrases, (std::vector<Words>{{"never", "closed"}}));
}

class SearchTest : public OnBoth {};
UGOKI_ON_BOTH(SearchTest);

TEST_P(SearchTest, FindsByTextKindAndTag) {
  Library library = open();
  ASSERT_TRUE(library.put(std::vector{make_item(EntryKind::motion, "12_01 Walk", "1", {"cmu", "slow"},
                                                R"({"source": "cmu_12_01_walk.bvh", "frames": 524, "deep": {"x": ["inner"]}})"),
                                      make_item(EntryKind::motion, "run", "2", {"cmu"}, R"({"source": "02_03.amc"})"),
                                      make_item(EntryKind::mechanism, "Walker", "3")}));
  const auto find = [&](std::string text, std::vector<std::string> kinds = {}, std::vector<std::string> tags = {}) {
    return names_of(library.find({std::move(text), std::move(kinds), std::move(tags), 100}));
  };
  EXPECT_EQ(find(""), (Words{"12_01 Walk", "run", "Walker"}));
  EXPECT_EQ(find("walk"), (Words{"12_01 Walk", "Walker"}));
  EXPECT_EQ(find("WALK", {"motion"}), Words{"12_01 Walk"});
  EXPECT_EQ(find("12_01"), Words{"12_01 Walk"});
  EXPECT_EQ(find("12_0"), Words{"12_01 Walk"});
  EXPECT_TRUE(find("01_12").empty());
  EXPECT_EQ(find("amc"), Words{"run"});
  EXPECT_EQ(find("inner"), Words{"12_01 Walk"});
  EXPECT_EQ(find("mechanism"), Words{"Walker"}) << "the kind can be searched as a word";
  EXPECT_EQ(find("", {}, {"cmu"}), (Words{"12_01 Walk", "run"}));
  EXPECT_EQ(find("", {}, {"cmu", "slow"}), Words{"12_01 Walk"});
  EXPECT_EQ(find("walk", {}, {"cmu"}), Words{"12_01 Walk"});
  EXPECT_TRUE(find("", {}, {"cm"}).empty()) << "a tag must match exactly";
  EXPECT_TRUE(find("frames").empty()) << "field names of the summary are not searched";
  EXPECT_TRUE(find("\" OR 1 --").empty());
  EXPECT_TRUE(find("%").empty());
  EXPECT_TRUE(find("'; DROP TABLE entry; --").empty());
  EXPECT_TRUE(find("walk)").size() == 2u);
  EXPECT_TRUE(find("name:walk").empty());
  EXPECT_TRUE(find("cmu slow walk 12 run").empty());
  EXPECT_TRUE(find("slow cmu").size() == 1u) << "the order of words does not matter";
  EXPECT_TRUE(find("\"cmu slow\"").empty()) << "a phrase must not match across two tags";
  EXPECT_FALSE(library.find({"", {"nonsense"}, {}, 10}));
}

TEST_P(SearchTest, FindsNamesOfAllScripts) {
  Library library = open();
  std::vector<LibraryItem> items;
  for (const char* name :
       {"二足歩行テスト", "歩く", "Läufer", "laufen", "02_01", "02_010", "2_1", "Ходьба", "ｗａｌｋ", "L'été", "straße", "a\xcc\x8a-ring"})
    items.push_back(make_item(EntryKind::motion, name, name));
  ASSERT_TRUE(library.put(items));
  const auto find = [&](std::string text) {
    Words found = names_of(library.find({.text = std::move(text)}));
    std::ranges::sort(found);
    return found;
  };
  EXPECT_EQ(find("歩行"), Words{"二足歩行テスト"});
  EXPECT_EQ(find("歩"), (Words{"二足歩行テスト", "歩く"}));
  EXPECT_EQ(find("テスト"), Words{"二足歩行テスト"});
  EXPECT_EQ(find("ﾃｽﾄ"), Words{"二足歩行テスト"});
  EXPECT_EQ(find("lauf"), (Words{"Läufer", "laufen"}));
  EXPECT_EQ(find("LÄUFER"), Words{"Läufer"});
  EXPECT_EQ(find("02_01"), (Words{"02_01", "02_010"}));
  EXPECT_EQ(find("2_1"), Words{"2_1"});
  EXPECT_EQ(find("ходь"), Words{"Ходьба"});
  EXPECT_EQ(find("walk"), Words{"ｗａｌｋ"});
  EXPECT_EQ(find("ete"), Words{"L'été"});
  EXPECT_EQ(find("STRASSE"), Words{"straße"});
  EXPECT_EQ(find("å-ri"), Words{"a\xcc\x8a-ring"});
}

TEST_P(SearchTest, OrdersByRelevanceNameTimeAndLength) {
  Library library = open();
  const auto put = [&](const char* name, const char* duration, std::vector<std::string> tags = {}) {
    ASSERT_TRUE(library.put(
        std::vector{make_item(EntryKind::motion, name, name, std::move(tags), std::string(R"({"duration": )") + duration + "}")}));
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // times are stored in milliseconds
  };
  put("a slow walk", "3.5");
  put("walk", "10");
  put("zigzag", "0.25", {"walk"});
  put("walking", "200");
  put("run", "1", {"fast walk"});
  const auto order = [&](LibraryOrder by, std::string text = "walk") {
    return names_of(library.find({.text = std::move(text), .order = by}));
  };
  EXPECT_EQ(order(LibraryOrder::relevance), (Words{"walk", "walking", "a slow walk", "run", "zigzag"}));
  EXPECT_EQ(order(LibraryOrder::name), (Words{"a slow walk", "run", "walk", "walking", "zigzag"}));
  EXPECT_EQ(order(LibraryOrder::longest), (Words{"walking", "walk", "a slow walk", "run", "zigzag"}));
  EXPECT_EQ(order(LibraryOrder::shortest, ""), (Words{"zigzag", "run", "a slow walk", "walk", "walking"}));
  const auto id = library.resolve("walk");
  ASSERT_TRUE(id && library.save({.id = id->id, .base = 1, .note = "seen"}));
  EXPECT_EQ(order(LibraryOrder::newest).front(), "walk");
  EXPECT_EQ(order(LibraryOrder::oldest).back(), "walk");
  EXPECT_EQ(order(LibraryOrder::oldest).front(), "a slow walk");
}

/// Random entries that consist of few different words, so that most searches find some of them.
std::vector<LibraryItem> random_items(std::mt19937& random, int count) {
  const char* words[] = {"walk", "walking", "run", "jump", "slow", "fast", "歩行", "02", "01", "été", "left", "turn"};
  const auto word = [&] { return words[random() % std::size(words)]; };
  std::vector<LibraryItem> items;
  for (int i = 0; i < count; ++i) {
    std::string name = word();
    for (auto n = random() % 3; n > 0; --n) name += std::string(random() % 2 ? "_" : " ") + word();
    std::vector<std::string> tags;
    for (auto n = random() % 3; n > 0; --n) tags.push_back(word());
    const EntryKind kind = entry_kinds[random() % std::size(entry_kinds)];
    items.push_back(make_item(kind, name, "data " + std::to_string(i), tags,
                              R"({"duration": )" + std::to_string(random() % 20) + R"(, "source": ")" + word() + R"("})"));
  }
  return items;
}

TEST(SearchOnBothTest, BothDatabasesMatchALinearSearch) {
  PostgresServer* server = PostgresServer::get();
  if (server == nullptr) GTEST_SKIP() << PostgresServer::unavailable_reason();
  TemporaryFolder folder;
  Result<Library> lite = Library::open(folder.path() + "/library.db"), team = Library::open(server->fresh_library());
  ASSERT_TRUE(lite && team);
  constexpr unsigned seed = 20260401;
  std::mt19937 random(seed);
  const std::vector<LibraryItem> items = random_items(random, 400);
  ASSERT_TRUE(lite->put(items) && team->put(items));
  Result<Library> lite_scan = Library::open(lite->path()), team_scan = Library::open(team->path());
  ASSERT_TRUE(lite_scan && team_scan);
  body_of(*lite_scan).sort_limit = body_of(*team_scan).sort_limit = 5;  // *_scan read rows in order; the other two sort the matches
  const char* texts[] = {"",         "wa",
                         "walk",     "walk slow",
                         "歩行",     "歩",
                         "02_01",    "\"02 01\"",
                         "le tu",    "motion",
                         "x",        "\"walk slow walk\"",
                         "02_01_02", "\"02 01\" walk"};
  const Words kinds[] = {{}, {"motion"}, {"mechanism", "set"}};
  const Words tags[] = {{}, {"walk"}, {"02", "歩行"}};
  constexpr LibraryOrder orders[] = {LibraryOrder::relevance, LibraryOrder::name, LibraryOrder::longest};
  int found = 0;
  for (const char* text : texts)
    for (const Words& kind : kinds)
      for (const Words& tag : tags)
        for (const LibraryOrder order : orders) {
          LibraryQuery query{.text = text, .kinds = kind, .tags = tag, .limit = 23, .order = order};
          const std::string description =
              std::string(text) + " order " + std::to_string(static_cast<int>(order)) + " seed " + std::to_string(seed);
          Words paged[4];
          Library* all[] = {&*lite, &*team, &*lite_scan, &*team_scan};
          for (int i = 0; i < 4; ++i) {
            query.after.clear();
            do {
              const auto page = all[i]->find(query);
              ASSERT_TRUE(page) << page.error().text();
              for (const LibraryEntry& e : page->entries) paged[i].push_back(e.id);
              if (query.after.empty() && i < 2) EXPECT_TRUE(page->total_exact);
              query.after = page->next;
              ASSERT_LE(paged[i].size(), 400u) << description;
            } while (!query.after.empty());
          }
          for (int i = 1; i < 4; ++i) EXPECT_EQ(paged[0], paged[i]) << description << ", library " << i;
          // The linear search: the set of matching entries, without order.
          const SearchPhrases phrases = search_phrases(text);
          Words expected;
          for (const LibraryItem& item : items) {
            bool fits = kind.empty() || std::ranges::find(kind, name_of(item.kind)) != kind.end();
            for (const std::string& t : tag) fits = fits && std::ranges::find(item.tags, t) != item.tags.end();
            Words fields = {item.name, std::string(name_of(item.kind)), item.summary.substr(item.summary.find("source") + 9)};
            fields.insert(fields.end(), item.tags.begin(), item.tags.end());
            for (const Words& phrase : phrases.phrases) {
              const auto contains_phrase = [&](const std::string& field) {
                const Words words = words_of(field);
                for (std::size_t at = 0; at + phrase.size() <= words.size(); ++at)
                  if (std::equal(phrase.begin(), phrase.end() - 1, words.begin() + static_cast<std::ptrdiff_t>(at)) &&
                      words[at + phrase.size() - 1].starts_with(phrase.back()))
                    return true;
                return false;
              };
              fits = fits && std::ranges::any_of(fields, contains_phrase);
            }
            if (fits) expected.push_back(entry_id(item.kind, item.data));
          }
          std::ranges::sort(expected);
          Words got = paged[0];
          std::ranges::sort(got);
          EXPECT_EQ(got, expected) << description;
          found += static_cast<int>(got.size());
        }
  EXPECT_GT(found, 500);
}

TEST_P(SearchTest, NextPageContinuesAfterChangesOfTheLibrary) {
  Library library = open();
  std::vector<LibraryItem> items;
  for (int i = 0; i < 50; ++i) items.push_back(make_item(EntryKind::motion, "walk " + std::to_string(100 + i), std::to_string(i)));
  ASSERT_TRUE(library.put(items));
  LibraryQuery query{.limit = 20};
  const auto first = library.find(query);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->total, 50u);
  query.after = first->next;
  ASSERT_TRUE(library.remove(first->entries.back().id));
  ASSERT_TRUE(
      library.put(std::vector{make_item(EntryKind::motion, "walk 1005", "before"), make_item(EntryKind::motion, "walk 1205", "behind")}));
  const auto second = library.find(query);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->entries.front().name, "walk 120");
  EXPECT_EQ(second->entries[1].name, "walk 1205");
  query.order = LibraryOrder::newest;
  EXPECT_FALSE(library.find(query)) << "the position belongs to another order";
  for (const char* wrong : {"nonsense", "MCwwLGEsYg", "//8=", "AAAA"}) {
    query.after = wrong;
    const auto refused = library.find(query);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().problems.front().code, ErrorCode::range);
  }
}

}  // namespace
}  // namespace ugoki::store
