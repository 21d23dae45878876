#include "ugoki/body/joint_names.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "ugoki/body/limb_geometry.h"

namespace ugoki::body {
namespace {

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char lower(char c) { return is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c; }

/// Splits a name into words in lower case: at punctuation, at a change from small to capital letters ("LeftUpLeg"), before the last of
/// several capitals ("LThigh"), and between letters and digits. A namespace before ':' or '|' is left out.
std::vector<std::string> words_of(const std::string& name) {
  const std::size_t start = name.find_last_of(":|");
  std::vector<std::string> words;
  std::string word;
  const auto close = [&] {
    if (!word.empty()) words.push_back(std::move(word));
    word.clear();
  };
  for (std::size_t i = start == std::string::npos || start + 1 >= name.size() ? 0 : start + 1; i < name.size(); ++i) {
    const char c = name[i];
    const bool letter = is_upper(c) || is_lower(c) || (static_cast<unsigned char>(c) & 0x80) != 0;
    if (!letter && !is_digit(c)) {
      close();
      continue;
    }
    const char before = i > 0 ? name[i - 1] : ' ';
    const bool next_lower = i + 1 < name.size() && is_lower(name[i + 1]);
    if (is_digit(c) != is_digit(before) || (is_upper(c) && is_lower(before)) || (is_upper(c) && is_upper(before) && next_lower)) close();
    word += lower(c);
  }
  close();
  return words;
}

/// Side that a word names: 1 left, -1 right, 0 none.
int side_of_word(std::string_view w) {
  static constexpr std::array left = {"l",  "left", "lt",     "lft", "lf",        "li",        "links",    "fl",
                                      "hl", "bl",   "gauche", "izq", "izquierda", "izquierdo", "sinistra", "sinister"};
  static constexpr std::array right = {"r",  "right",  "rt",    "rgt", "rf",      "re",      "rechts", "fr",    "hr",
                                       "br", "droite", "droit", "der", "derecha", "derecho", "destra", "dexter"};
  for (const char* s : left)
    if (w == s) return 1;
  for (const char* s : right)
    if (w == s) return -1;
  return 0;
}

/// Meaning of a word or of several words joined.
struct Entry {
  std::string_view word;
  Part part;
  Part second = Part::other;
};

// Longer words come before words that they contain.
constexpr Entry parts_by_word[] = {
    // legs
    {"hipjoint", Part::hip},
    {"upperleg", Part::thigh},
    {"uplegs", Part::thigh},
    {"upleg", Part::thigh},
    {"legupper", Part::thigh},
    {"legup", Part::thigh},
    {"thigh", Part::thigh},
    {"femur", Part::thigh},
    {"oberschenkel", Part::thigh},
    {"cuisse", Part::thigh},
    {"muslo", Part::thigh},
    {"coscia", Part::thigh},
    {"lowerleg", Part::shank},
    {"lowleg", Part::shank},
    {"leglower", Part::shank},
    {"leglow", Part::shank},
    {"knee", Part::shank},
    {"shin", Part::shank},
    {"shank", Part::shank},
    {"calf", Part::shank},
    {"tibia", Part::shank},
    {"crus", Part::shank},
    {"unterschenkel", Part::shank},
    {"mollet", Part::shank},
    {"pantorrilla", Part::shank},
    {"polpaccio", Part::shank},
    {"toebase", Part::toes},
    {"toes", Part::toes},
    {"toe", Part::toes},
    {"ballofthefoot", Part::toes},
    {"midfoot", Part::toes},
    {"orteil", Part::toes},
    {"zehe", Part::toes},
    {"foot", Part::foot},
    {"feet", Part::foot},
    {"ankle", Part::foot},
    {"heel", Part::foot},
    {"talus", Part::foot},
    {"calcn", Part::foot},
    {"tarsal", Part::foot},
    {"tarsus", Part::foot},
    {"fuss", Part::foot},
    {"pied", Part::foot},
    {"ball", Part::toes},
    // arms
    {"forearm", Part::forearm},
    {"lowerarm", Part::forearm},
    {"lowarm", Part::forearm},
    {"armlower", Part::forearm},
    {"armlow", Part::forearm},
    {"elbow", Part::forearm},
    {"radius", Part::forearm},
    {"ulna", Part::forearm},
    {"unterarm", Part::forearm},
    {"avantbras", Part::forearm},
    {"antebrazo", Part::forearm},
    {"avambraccio", Part::forearm},
    {"upperarm", Part::upper_arm},
    {"uparm", Part::upper_arm},
    {"armupper", Part::upper_arm},
    {"armup", Part::upper_arm},
    {"humerus", Part::upper_arm},
    {"oberarm", Part::upper_arm},
    {"shldr", Part::upper_arm, Part::shoulder},
    {"clavicle", Part::shoulder},
    {"clavicule", Part::shoulder},
    {"clavicula", Part::shoulder},
    {"clav", Part::shoulder},
    {"collar", Part::shoulder},
    {"scapula", Part::shoulder},
    {"shoulder", Part::shoulder, Part::upper_arm},
    {"schulter", Part::shoulder, Part::upper_arm},
    {"epaule", Part::shoulder, Part::upper_arm},
    {"hombro", Part::shoulder, Part::upper_arm},
    {"spalla", Part::shoulder, Part::upper_arm},
    {"thumb", Part::thumb},
    {"daumen", Part::thumb},
    {"pouce", Part::thumb},
    {"finger", Part::fingers},
    {"index", Part::fingers},
    {"middle", Part::fingers},
    {"pinky", Part::fingers},
    {"little", Part::fingers},
    {"ring", Part::fingers},
    {"metacarp", Part::fingers},
    {"carpal", Part::fingers},
    {"hand", Part::hand},
    {"wrist", Part::hand},
    {"palm", Part::hand},
    {"carpus", Part::hand},
    {"poignet", Part::hand},
    {"mano", Part::hand},
    // middle
    {"headtop", Part::other},
    {"head", Part::head},
    {"skull", Part::head},
    {"cranium", Part::head},
    {"kopf", Part::head},
    {"tete", Part::head},
    {"cabeza", Part::head},
    {"testa", Part::head},
    {"neck", Part::neck},
    {"hals", Part::neck},
    {"nacken", Part::neck},
    {"cervical", Part::neck},
    {"spine", Part::trunk},
    {"chest", Part::trunk},
    {"thorax", Part::trunk},
    {"torso", Part::trunk},
    {"sternum", Part::trunk},
    {"abdomen", Part::trunk},
    {"belly", Part::trunk},
    {"waist", Part::trunk},
    {"lumbar", Part::trunk},
    {"ribcage", Part::trunk},
    {"ribs", Part::trunk},
    {"trunk", Part::trunk},
    {"upperback", Part::trunk},
    {"lowerback", Part::trunk},
    {"back", Part::trunk},
    {"wirbel", Part::trunk},
    {"colonne", Part::trunk},
    {"pelvis", Part::pelvis},
    {"becken", Part::pelvis},
    {"bassin", Part::pelvis},
    {"hips", Part::pelvis, Part::thigh},
    {"hip", Part::thigh, Part::pelvis},
    {"hueft", Part::thigh, Part::pelvis},
    {"cog", Part::pelvis},
    // words with several meanings
    {"leg", Part::shank, Part::thigh},
    {"jambe", Part::shank, Part::thigh},
    {"pierna", Part::thigh, Part::shank},
    {"gamba", Part::thigh, Part::shank},
    {"bein", Part::thigh, Part::shank},
    {"arm", Part::upper_arm, Part::forearm},
    {"bras", Part::upper_arm, Part::forearm},
    {"brazo", Part::upper_arm, Part::forearm},
    {"braccio", Part::upper_arm, Part::forearm},
};

constexpr std::string_view helper_words[] = {
    "twist",     "roll",   "nub",     "effector",   "end",   "site",  "ik",   "fk",     "pole",       "target", "ctrl",   "helper",
    "aux",       "jiggle", "share",   "breast",     "boob",  "pec",   "hair", "skirt",  "cloth",      "cape",   "camera", "light",
    "footsteps", "prop",   "weapon",  "sword",      "gun",   "eye",   "eyes", "eyelid", "jaw",        "tongue", "brow",   "eyebrow",
    "lip",       "lips",   "teeth",   "face",       "cheek", "nose",  "ear",  "muscle", "corrective", "bulge",  "socket", "attach",
    "headtop",   "tip",    "control", "controller", "hat",   "mouth", "chin", "nostril"};

bool is_control_word(std::string_view w) {
  return w == "ik" || w == "fk" || w == "ctrl" || w == "control" || w == "controller" || w == "target";
}
bool is_helper_word(std::string_view w) { return std::ranges::find(helper_words, w) != std::end(helper_words); }

const Entry* find_entry(std::string_view joined) {
  for (const Entry& e : parts_by_word)
    if (joined == e.word) return &e;
  return nullptr;
}
const Entry* find_contained(std::string_view joined) {
  for (const Entry& e : parts_by_word)
    if (e.word.size() >= 3 && joined.find(e.word) != std::string_view::npos) return &e;
  return nullptr;
}

/// Removes from `word` a side that is written without a separator ("leftfoot", "rthumb"). @return the side
int take_side(std::string& word) {
  for (const auto& [mark, side] : {std::pair<std::string_view, int>{"left", 1}, {"right", -1}}) {
    if (word.size() > mark.size() && word.starts_with(mark)) {
      word.erase(0, mark.size());
      return side;
    }
    if (word.size() > mark.size() && word.ends_with(mark)) {
      word.erase(word.size() - mark.size());
      return side;
    }
  }
  if (word.size() > 2 && (word[0] == 'l' || word[0] == 'r')) {
    const std::string rest = word.substr(1);
    if (!find_entry(word) && (find_entry(rest) || (rest.size() > 5 && find_contained(rest) && !find_contained(word.substr(0, 4))))) {
      const int side = word[0] == 'l' ? 1 : -1;
      word = rest;
      return side;
    }
  }
  return 0;
}

/// Removes from `word` a girdle that is written without a separator ("frontleg", "hindpaw", "legback"). "forefoot" and "hindfoot" are also
/// parts of a person's foot and stay. @return 1: fore limb, -1: hind limb, 0: none
int take_girdle(std::string& word) {
  for (const auto& [mark, girdle] : {std::pair<std::string_view, int>{"front", 1}, {"fore", 1}, {"hind", -1}, {"rear", -1}, {"back", -1}}) {
    if (word.size() <= mark.size() || (!word.starts_with(mark) && !word.ends_with(mark))) continue;
    const std::string rest = word.starts_with(mark) ? word.substr(mark.size()) : word.substr(0, word.size() - mark.size());
    const Entry* e = find_entry(rest);
    const bool of_person = rest == "foot" && (mark == "fore" || mark == "hind");
    if (of_person || (rest != "paw" && rest != "hoof" && (!e || !is_leg(e->part)))) continue;
    word = rest;
    return girdle;
  }
  return 0;
}

std::string without(std::string text, std::string_view word) {
  const std::size_t i = text.find(word);
  return i == std::string::npos ? text : text.erase(i, word.size());
}

/// The part of an arm that corresponds to a part of a leg; other parts stay.
Part counterpart(Part leg) {
  switch (leg) {
    case Part::hip: return Part::shoulder;
    case Part::thigh: return Part::upper_arm;
    case Part::shank: return Part::forearm;
    case Part::foot: return Part::hand;
    case Part::toes: return Part::fingers;
    default: return leg;
  }
}

NameEvidence evidence_of(const std::vector<std::string>& words) {
  NameEvidence out;
  std::string joined;
  bool control = false, follows = false, back = false, letter_f = false, letter_b = false;
  for (std::string word : words) {
    if (is_digit(word[0])) continue;
    if (const int side = side_of_word(word); side != 0) {
      if (out.side == 0) out.side = side;
      out.fore = out.fore || word == "fl" || word == "fr";
      out.hind = out.hind || word == "hl" || word == "hr" || word == "bl" || word == "br";
      continue;
    }
    if (word == "lfront" || word == "lfore") out.side = 1;
    if (const int side = take_side(word); side != 0 && out.side == 0) out.side = side;
    if (const int girdle = take_girdle(word); girdle != 0) (girdle > 0 ? out.fore : out.hind) = true;
    if (is_control_word(word)) {
      control = true;
      continue;
    }
    follows = follows || is_helper_word(word) || word.ends_with("twist") || word.ends_with("roll") || word.ends_with("nub") ||
              word.starts_with("twist");
    out.end = out.end || word == "nub" || word == "end" || word == "tip" || word == "site" || word == "effector" || word == "headtop" ||
              word.ends_with("nub");
    for (const char* tail : {"tail", "tale", "schwanz", "queue", "cola", "coda", "cauda", "hvost"})
      out.tail = out.tail || word == tail || (word.starts_with("tail") && word.size() > 4);
    out.wing = out.wing || word.find("wing") != std::string::npos || word.find("feather") != std::string::npos;
    out.paw = out.paw || word == "paw" || word == "hoof" || word == "claw" || word == "pfote" || word == "fetlock" || word == "pastern" ||
              word == "hock";
    out.fore = out.fore || word == "front" || word == "fore" || word == "frt" || word == "anterior" || word == "forward";
    out.hind = out.hind || word == "hind" || word == "rear" || word == "posterior" || word == "bck";
    letter_f = letter_f || word == "f";
    letter_b = letter_b || word == "b";
    back = back || word == "back" || word == "backward";
    if (word != "f" && word != "b") joined += word;
  }
  out.helper = control || follows;
  out.control = control && !follows;
  if (const Entry* e = find_entry(joined)) {
    out.part = e->part;
    out.second = e->second;
  } else if (!joined.empty()) {
    e = find_contained(joined);
    if (e) {
      out.part = e->part;
      out.second = e->second;
    }
  }
  // "Back" is a part of the trunk, but "BackLeg" a hind leg.
  if (back && joined != "back")
    if (const Entry* e = find_contained(without(joined, "back")); e && (is_leg(e->part) || is_arm(e->part))) {
      out.part = is_leg(e->part) ? e->part : Part::other;
      out.second = is_leg(e->part) ? e->second : Part::other;
      out.hind = true;
    }
  if (out.part == Part::forearm) out.fore = false;  // "ForeArm" is no fore limb
  out.weak = joined == "wrist" || joined == "heel" || joined == "hipjoint";
  // A hip with a side is a thigh; a hip without a side is the pelvis.
  if (out.part == Part::thigh && out.second == Part::pelvis) out.part = out.side != 0 ? Part::thigh : Part::pelvis;
  if (out.part == Part::pelvis && out.second == Part::thigh) out.part = out.side != 0 ? Part::thigh : Part::pelvis;
  if (is_leg(out.part) && !out.fore && !out.hind && letter_f != letter_b) {  // "leg.F.L"
    out.fore = letter_f;
    out.hind = letter_b;
  }
  if (out.fore && is_leg(out.part)) {
    out.part = counterpart(out.part);
    out.second = counterpart(out.second);
  }
  return out;
}

}  // namespace

std::vector<NameEvidence> read_joint_names(std::span<const std::string> names) {
  std::vector<std::vector<std::string>> words;
  std::map<std::string, std::size_t> count;
  for (const std::string& name : names) {
    words.push_back(words_of(name));
    const std::set<std::string> distinct(words.back().begin(), words.back().end());
    for (const std::string& w : distinct) ++count[w];
  }
  for (std::vector<std::string>& list : words) {
    std::vector<std::string> kept;
    for (const std::string& w : list)
      if (count[w] * 10 <= names.size() * 6 || names.size() < 4) kept.push_back(w);
    // A side in a prefix ("L", "left") is kept, because only about half of the joints share it.
    if (!kept.empty()) list = std::move(kept);
  }
  std::vector<NameEvidence> out;
  out.reserve(words.size());
  for (const auto& list : words) out.push_back(evidence_of(list));
  return out;
}

}  // namespace ugoki::body
