#pragma once
// What full-text search sees: both databases are given the same words, so they find the same entries. Internal to store.
//
// Texts are brought to one form (compatibility form, no case, no diacritics above or below letters) and cut into words at all that is no
// letter, digit or mark. Chinese and Japanese, which put no blanks between words, are cut into characters; a word of the search is found as
// the characters in a row. So `02_01` are the words 02 and 01 in a row, "Läufer" and "LAUFER" are equal, and 歩行 is found in 二足歩行.

#include <string>
#include <string_view>
#include <vector>

namespace ugoki::store {

/// The text as valid UTF-8 without control characters: what is no UTF-8 becomes U+FFFD, line ends and tabs stay.
[[nodiscard]] std::string clean_text(std::string_view text);

/// The words of a text in its one form, at most `most_words`; longer words than `longest_word` bytes are cut.
[[nodiscard]] std::vector<std::string> words_of(std::string_view text);
inline constexpr std::size_t most_words = 2000;
inline constexpr std::size_t longest_word = 120;

/// The words of a name with blanks between: the order of lists, and what "begins with" means.
[[nodiscard]] std::string name_key(std::string_view name);

/// All words of an entry: those of the name first, a mark that is no word between two fields, so that nothing is found across them.
struct SearchText {
  std::vector<std::string> name, other;
  std::vector<std::string> marks;  ///< of the kind, the tags and the name's words, see below: only in the index
  void add_other(std::string_view text);
  /// " walk slow <mark> cmu ...": each word after a blank.
  [[nodiscard]] std::string all() const;
  [[nodiscard]] std::string name_words() const;   ///< for the column `name` of FTS5
  [[nodiscard]] std::string other_words() const;  ///< for the column `other` of FTS5
  [[nodiscard]] std::string mark_words() const;   ///< for the column `marks` of FTS5
  /// A literal of PostgreSQL's type tsvector.
  [[nodiscard]] std::string tsvector() const;
};

/// Words that no text can hold: they stand for a kind, for exactly this tag, so that the index alone can tell what fits a whole query.
[[nodiscard]] std::string kind_mark(std::string_view kind);
[[nodiscard]] std::string tag_mark(std::string_view tag);
/// A word of a name: searching names alone then costs what their words cost, not what all texts cost.
[[nodiscard]] std::string name_mark(std::string_view word);

/// Two words in a row, somewhere or in the name. PostgreSQL's index knows no places; with these it knows what stands in a row.
[[nodiscard]] std::string pair_mark(bool of_name, std::string_view first, std::string_view second);

/// What somebody looks for: all of the phrases; each is words in a row, of which the last may go on.
struct SearchPhrases {
  bool nothing = false;  ///< there is a text, but no word in it: nothing can be found
  std::vector<std::vector<std::string>> phrases;
  std::string key;  ///< all words with blanks between, for "the name begins with"

  [[nodiscard]] bool empty() const { return phrases.empty(); }
  /// The phrase as it stands in SearchText::all(): " 02 01".
  [[nodiscard]] std::string in_words(std::size_t phrase) const;
  /// As a query of the index: all of the phrases, of the name only if `in_name`, all of `tags`, one of `kinds` (none: any).
  [[nodiscard]] std::string fts5(bool in_name, const std::vector<std::string>& tags, const std::vector<std::string>& kinds) const;
  /// @param in_a_row the words of a phrase stand in a row; otherwise each two that follow each other do, somewhere
  [[nodiscard]] std::string tsquery(bool in_name, const std::vector<std::string>& tags, const std::vector<std::string>& kinds,
                                    bool in_a_row) const;
  [[nodiscard]] bool any_longer_than_pairs() const;  ///< a phrase of three words or more
};
/// Words of `text` are separated by blanks; "..." holds several together.
[[nodiscard]] SearchPhrases search_phrases(std::string_view text);

}  // namespace ugoki::store
