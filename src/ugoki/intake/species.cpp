#include "ugoki/intake/species.h"

#include <algorithm>
#include <vector>

namespace ugoki::intake {
namespace {

/// Masses [kg] of weaned young animals to large adults, rounded (Nowak, Walker's Mammals of the World, 1999; breeds: FCI and breed
/// societies).
struct Range {
  std::string_view name;
  double lightest, heaviest;
};
constexpr Range ranges[] = {
    {"mouse", 0.015, 0.06},  {"hamster", 0.02, 0.2},  {"rat", 0.1, 0.7},     {"squirrel", 0.1, 1.5}, {"guineapig", 0.4, 1.5},
    {"ferret", 0.5, 2.5},    {"rabbit", 0.4, 6},      {"bunny", 0.4, 6},     {"hare", 1, 6},         {"cat", 1, 8},
    {"kitten", 0.4, 3},      {"kitty", 0.4, 8},       {"lynx", 8, 35},       {"fox", 2, 14},         {"raccoon", 2, 15},
    {"badger", 5, 18},       {"beaver", 8, 35},       {"otter", 3, 40},      {"dog", 2, 80},         {"puppy", 1, 20},
    {"pup", 1, 20},          {"hound", 8, 50},        {"husky", 14, 32},     {"shiba", 6, 13},       {"corgi", 8, 16},
    {"labrador", 20, 42},    {"retriever", 20, 42},   {"shepherd", 18, 45},  {"beagle", 8, 18},      {"pug", 5, 11},
    {"bulldog", 15, 30},     {"dachshund", 3, 14},    {"dalmatian", 18, 35}, {"poodle", 3, 35},      {"dane", 40, 90},
    {"coyote", 7, 22},       {"jackal", 6, 16},       {"wolf", 15, 80},      {"hyena", 20, 85},      {"deer", 10, 300},
    {"doe", 10, 180},        {"fawn", 3, 25},         {"stag", 40, 350},     {"hart", 40, 350},      {"elk", 100, 500},
    {"moose", 150, 750},     {"reindeer", 50, 300},   {"caribou", 50, 300},  {"antelope", 10, 300},  {"gazelle", 10, 75},
    {"goat", 8, 130},        {"ibex", 25, 130},       {"sheep", 20, 160},    {"ram", 30, 160},       {"lamb", 4, 40},
    {"pig", 10, 350},        {"piglet", 1, 15},       {"hog", 20, 350},      {"boar", 25, 250},      {"horse", 90, 1000},
    {"mare", 150, 1000},     {"stallion", 200, 1000}, {"foal", 30, 250},     {"pony", 90, 400},      {"unicorn", 90, 1000},
    {"donkey", 70, 480},     {"mule", 150, 600},      {"zebra", 170, 450},   {"cow", 150, 1100},     {"cattle", 150, 1100},
    {"bull", 250, 1200},     {"ox", 250, 1200},       {"calf", 30, 250},     {"buffalo", 250, 1100}, {"bison", 250, 1100},
    {"yak", 180, 1000},      {"llama", 60, 200},      {"alpaca", 35, 90},    {"camel", 250, 1000},   {"lion", 80, 270},
    {"lioness", 80, 190},    {"tiger", 65, 320},      {"leopard", 20, 95},   {"panther", 25, 120},   {"jaguar", 35, 150},
    {"puma", 25, 100},       {"cougar", 25, 100},     {"cheetah", 18, 75},   {"bear", 30, 650},      {"panda", 50, 160},
    {"elephant", 300, 7000}, {"rhino", 400, 3000},    {"hippo", 300, 3200},  {"giraffe", 200, 1900}, {"pferd", 90, 1000},
    {"hund", 2, 80},         {"katze", 1, 8},         {"kuh", 150, 1100},    {"schaf", 20, 160}};

/// Words in lower case.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  char before = ' ';
  for (const char c : name) {
    const bool upper = c >= 'A' && c <= 'Z', letter = upper || (c >= 'a' && c <= 'z');
    if ((!letter || (upper && before >= 'a' && before <= 'z')) && !words.back().empty()) words.emplace_back();
    if (letter) words.back() += upper ? static_cast<char>(c - 'A' + 'a') : c;
    before = c;
  }
  return words;
}

/// Parts of file names that are written together with the name of an animal ("bigcat", "foxwalk").
constexpr std::string_view companions[] = {
    "walk",  "run",    "idle",   "trot",     "gallop",  "jump", "eat",     "attack", "anim",      "animation", "animated", "rig",  "rigged",
    "mesh",  "model",  "low",    "poly",     "lowpoly", "toon", "cartoon", "char",   "character", "final",     "new",      "old",  "test",
    "big",   "baby",   "little", "small",    "my",      "the",  "black",   "white",  "brown",     "red",       "grey",     "gray", "wild",
    "house", "arctic", "polar",  "mountain", "were",    "tom",  "toy",     "blend",  "export",    "skin",      "base",     "all"};

/// Adds the longest species name that the word is, or begins or ends with. Short names are parts of other words ("rate", "ramp", "cowboy"),
/// so they count only if the rest of the word is usual beside the name of an animal. A name of two letters counts only as the whole word,
/// and so does "calf", which is also a part of a leg.
void add_species(const std::string& word, std::vector<const Range*>& found) {
  constexpr std::size_t longest_short = 4;  // letters
  const Range* best = nullptr;
  for (const Range& r : ranges) {
    const bool begins = word.starts_with(r.name), ends = word.ends_with(r.name);
    if ((!begins && !ends) || word.size() < r.name.size()) continue;
    const std::string_view rest =
        begins ? std::string_view(word).substr(r.name.size()) : std::string_view(word).substr(0, word.size() - r.name.size());
    const bool ending = rest == "s" || rest == "y",
               usual = r.name.size() > longest_short || (ending && begins) || std::ranges::find(companions, rest) != std::end(companions);
    const bool part = r.name.size() > 2 && r.name != "calf" && usual;
    if ((word == r.name || part) && (!best || r.name.size() > best->name.size())) best = &r;
  }
  if (best && std::ranges::find(found, best) == found.end()) found.push_back(best);
}

std::optional<SpeciesMass> common_range(const std::vector<const Range*>& found, std::string source) {
  if (found.empty()) return std::nullopt;
  SpeciesMass out{.names = {}, .source = std::move(source), .lightest = 1e300, .heaviest = 0};
  for (const Range* r : found) {
    out.names += (out.names.empty() ? "" : ", ") + std::string(r->name);
    out.lightest = std::min(out.lightest, r->lightest);
    out.heaviest = std::max(out.heaviest, r->heaviest);
  }
  return out;
}

}  // namespace

std::optional<SpeciesMass> species_mass(std::string_view name) {
  for (const Range& r : ranges)
    if (r.name == name) return SpeciesMass{std::string(r.name), {}, r.lightest, r.heaviest};
  return std::nullopt;
}

std::optional<SpeciesMass> species_in_names(std::string_view file_name, std::span<const std::string> others) {
  std::vector<const Range*> found;
  const std::string_view stem = file_name.substr(0, file_name.rfind('.'));
  for (const std::string& word : words_of(stem)) add_species(word, found);
  if (auto out = common_range(found, "the file's name")) return out;
  for (const std::string& name : others)
    for (const std::string& word : words_of(name))
      if (word != "calf") add_species(word, found);
  return common_range(found, "names in the file");
}

std::string known_species() {
  std::string out;
  for (const Range& r : ranges) out += (out.empty() ? "" : ", ") + std::string(r.name);
  return out;
}

}  // namespace ugoki::intake
