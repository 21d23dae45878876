#include "ugoki/publish/page.h"

#include <zlib.h>

#include <vector>

#include "ugoki/base/base64.h"
#include "ugoki/base/check.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/content/mechanism_display.h"
#include "ugoki/content/player.h"

namespace ugoki::publish {
namespace {

/// Replaces the only occurrence of `mark`. @return false if there is none
bool replace(std::string& text, std::string_view mark, std::string_view by) {
  const std::size_t at = text.find(mark);
  if (at == std::string::npos) return false;
  text.replace(at, mark.size(), by);
  return true;
}

/// Removes the content of `<script ... id="ID">...</script>`.
bool empty_script(std::string& text, std::string_view id) {
  const std::size_t at = text.find("id=\"" + std::string(id) + "\">");
  if (at == std::string::npos) return false;
  const std::size_t begin = text.find('>', at) + 1, end = text.find("</script>", begin);
  if (end == std::string::npos) return false;
  text.erase(begin, end - begin);
  return true;
}

/// Packs bytes for a script element: gzip in Base64.
std::string pack(std::span<const std::byte> bytes) {
  const std::string packed = to_gzip(bytes);
  return to_base64({reinterpret_cast<const std::uint8_t*>(packed.data()), packed.size()});
}

}  // namespace

std::string first_picture(std::span<const std::byte> ugx) {
  Result<content::Player> player = content::Player::open(ugx);
  if (!player) return {};
  content::DisplayFrame frame;
  player->display_frame(frame);
  std::vector<std::byte> bytes;
  content::encode_frame(frame, 0, content::frame_simulate, bytes);
  return R"({"scene":)" + content::scene_json(player->content(), false) + R"(,"devices":)" +
         circuit::write_device_use(player->devices().use()) + R"(,"frame":")" +
         to_base64({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}) + R"("})";
}

std::string escape_html(std::string_view text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      case '\'': out += "&#39;"; break;
      default: out += c;
    }
  return out;
}

std::string to_gzip(std::span<const std::byte> bytes) {
  z_stream stream{};
  UGOKI_CHECK(deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 9, Z_DEFAULT_STRATEGY) == Z_OK);
  std::string out;
  std::string part(1 << 16, '\0');
  constexpr std::size_t max_part = 1u << 30;  // zlib counts with 32 bits
  int status = Z_OK;
  do {
    const std::size_t size = std::min(bytes.size(), max_part);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(size);
    bytes = bytes.subspan(size);
    do {
      stream.next_out = reinterpret_cast<Bytef*>(part.data());
      stream.avail_out = static_cast<uInt>(part.size());
      status = deflate(&stream, bytes.empty() ? Z_FINISH : Z_NO_FLUSH);
      out.append(part, 0, part.size() - stream.avail_out);
    } while (stream.avail_out == 0);
  } while (status != Z_STREAM_END && !bytes.empty());
  deflateEnd(&stream);
  UGOKI_CHECK(status == Z_STREAM_END);
  return out;
}

Result<std::string> make_page(std::string page, std::string_view title, std::span<const std::byte> ugx, PageEngine engine) {
  const std::string content = engine == PageEngine::inside ? pack(ugx) : "";
  const std::string first = engine == PageEngine::inside ? first_picture(ugx) : "";
  bool good = replace(page, "@UGOKI_TITLE@", escape_html(title)) && replace(page, "@UGOKI_CONTENT@", content) &&
              replace(page, "@UGOKI_FIRST@", first.empty() ? "" : pack(std::as_bytes(std::span(first))));
  if (engine != PageEngine::inside) good = good && empty_script(page, "ugoki-engine");
  if (engine != PageEngine::inside)
    good = good && replace(page, "<html lang=\"en\">",
                           engine == PageEngine::native ? R"(<html lang="en" data-engine="native">)"
                                                        : R"(<html lang="en" data-engine="pictures">)");
  if (!good)
    return fail(ErrorCode::structure, "player.html", "The player's page lacks a placeholder, so another version of Ugoki made it.",
                "Build the page again: run ./start once.");
  return page;
}

}  // namespace ugoki::publish
