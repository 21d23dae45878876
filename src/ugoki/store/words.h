#pragma once
// Words for full-text search. Both databases index the same words, so they find the same entries. Internal to store.
//
// Texts are folded (Unicode compatibility form, case-folded, without combining accents U+0300 ... U+036F) and split into words at every
// character that is not a letter, digit or mark. Chinese and Japanese text has no blanks between words, so each character is a word, and a
// search word is a phrase of adjacent characters. Examples: `02_01` is the phrase of the words 02 and 01; "Läufer" equals "LAUFER"; 歩行 is
// found in 二足歩行.
//
// Mark: an additional index term that no text can contain, because it begins with a private-use character.

#include <string>
#include <string_view>
#include <vector>

namespace ugoki::store {

/// The text as valid UTF-8 without control characters, except line feeds and tabs. Invalid bytes become U+FFFD.
[[nodiscard]] std::string clean_text(std::string_view text);

/// The folded words of a text: at most the first max_words words, each truncated to max_word_size bytes.
[[nodiscard]] std::vector<std::string> words_of(std::string_view text);
inline constexpr std::size_t max_words = 2000;
inline constexpr std::size_t max_word_size = 120;  ///< maximum size of a word, bytes of UTF-8

/// The folded words of a name, separated by blanks. Lists are sorted by this key, and "the name begins with" is tested on it.
[[nodiscard]] std::string name_key(std::string_view name);

/// All words of an entry for the search. A separator between two fields prevents phrases from matching across fields.
struct SearchText {
  std::vector<std::string> name;   ///< folded words of the name
  std::vector<std::string> other;  ///< words of the other fields, with a separator between two fields
  std::vector<std::string> marks;  ///< marks of the kind, the tags and the words of the name; only in the index
  /// Appends the words of another field to `other`.
  void add_other(std::string_view text);
  /// All words with a blank before each, for substring tests: " walk slow <separator> cmu ...".
  [[nodiscard]] std::string all() const;
  [[nodiscard]] std::string name_words() const;   ///< text for the column `name` of SQLite's FTS5 table
  [[nodiscard]] std::string other_words() const;  ///< text for the column `other` of SQLite's FTS5 table
  [[nodiscard]] std::string mark_words() const;   ///< text for the column `marks` of SQLite's FTS5 table
  /// All words as a literal of PostgreSQL's type tsvector.
  [[nodiscard]] std::string tsvector() const;
};

/// Index term (mark) for a kind. With the marks for kinds and tags, one query of the index can test text, kind and tags.
[[nodiscard]] std::string kind_mark(std::string_view kind);
/// Index term (mark) for exactly this tag; contains the hash of the tag.
[[nodiscard]] std::string tag_mark(std::string_view tag);
/// Index term (mark) for a word of a name. With these marks, a search in names reads only the index entries of names.
[[nodiscard]] std::string name_mark(std::string_view word);

/// Index term (mark) for two adjacent words. Used for PostgreSQL, whose index stores no word positions.
/// @param of_name true: the words are adjacent in the name; false: in any field
[[nodiscard]] std::string pair_mark(bool of_name, std::string_view first, std::string_view second);

/// A parsed search text. An entry must contain all phrases. A phrase is a list of adjacent words; the last may be the beginning of a word.
struct SearchPhrases {
  bool nothing = false;  ///< the text is not blank but contains no word: no entry matches
  std::vector<std::vector<std::string>> phrases;
  std::string key;  ///< all words, separated by blanks, for the test "the name begins with"

  [[nodiscard]] bool empty() const { return phrases.empty(); }
  /// The words of one phrase with a blank before each, as in SearchText::all(): " 02 01". @param phrase index into `phrases`
  [[nodiscard]] std::string in_words(std::size_t phrase) const;
  /// Query for SQLite's FTS5 index: all phrases, all `tags`, and one of `kinds` (empty: any). @param in_name search only the words of names
  [[nodiscard]] std::string fts5(bool in_name, const std::vector<std::string>& tags, const std::vector<std::string>& kinds) const;
  /// Query for PostgreSQL, with the parameters of fts5(). @param exact_phrases true: the words of a phrase must be adjacent (needs the
  /// positions in the row); false: only each pair of consecutive words must be adjacent (the index can test this)
  [[nodiscard]] std::string tsquery(bool in_name, const std::vector<std::string>& tags, const std::vector<std::string>& kinds,
                                    bool exact_phrases) const;
  [[nodiscard]] bool any_longer_than_pairs() const;  ///< true: a phrase has three or more words
};
/// Parses a search text. Blanks separate phrases; double quotes enclose a phrase of several words. At most 16 phrases are used.
[[nodiscard]] SearchPhrases search_phrases(std::string_view text);

}  // namespace ugoki::store
