#pragma once
// One HTML file that plays content in a browser, from a disk and without a network.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::publish {

/// Where the engine of a page runs.
enum class PageEngine {
  inside,   ///< in the page, as WebAssembly
  native,   ///< in the program that serves the page; the page has neither engine nor content
  pictures  ///< in the program that serves the page; the page draws pictures for it
};

/// Returns the player's page with its placeholders filled. @param page text of player.html, which Ugoki's build makes
/// @param ugx executable data
/// Errors: the page lacks one of its placeholders.
[[nodiscard]] Result<std::string> make_page(std::string page, std::string_view title, std::span<const std::byte> ugx,
                                            PageEngine engine = PageEngine::inside);

/// Returns what a page needs to draw its first picture before its engine is unpacked: one JSON object with `scene` (content::scene_json()),
/// `devices` (circuit::write_device_use()) and `frame` (content::encode_frame() in Base64). Empty if the content cannot be opened; the
/// engine of the page then reports why. @param ugx executable data
[[nodiscard]] std::string first_picture(std::span<const std::byte> ugx);

/// Compresses bytes to gzip (RFC 1952) with the highest compression. Equal bytes give equal results.
[[nodiscard]] std::string to_gzip(std::span<const std::byte> bytes);

/// Returns the text with the characters & < > " and ' replaced by HTML entities.
[[nodiscard]] std::string escape_html(std::string_view text);

}  // namespace ugoki::publish
