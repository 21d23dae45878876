#include "ugoki/studio/export_service.h"

#include "ugoki/content/player.h"
#include "ugoki/publish/page.h"
#include "ugoki/publish/parts.h"
#include "ugoki/publish/payload.h"
#include "ugoki/publish/take.h"

namespace ugoki::studio {
namespace {

std::string text_of(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

Result<ApiReply> export_content(std::string_view form, std::string_view name, const std::vector<std::byte>& ugx) {
  if (form == "ugx") return ApiReply{200, text_of(ugx), "application/octet-stream"};
  // The content is opened with the standard LSIs only, because a page and a native program have no others.
  Result<content::Player> player = content::Player::open(ugx, name);
  if (!player) return fail(std::move(player.error()));
  if (form == "html" || form == "native") {
    Result<std::string> page = publish::read_player_part("player.html");
    if (!page) return fail(std::move(page.error()));
    const bool native = form == "native";
    page = publish::make_page(std::move(*page), name, ugx, native ? publish::PageEngine::native : publish::PageEngine::inside);
    if (!page) return fail(std::move(page.error()));
    // Pages are sent as octet-stream too. A page that the studio's origin showed could run its scripts with the studio's rights.
    if (!native) return ApiReply{200, std::move(*page), "application/octet-stream"};
    const Result<std::string> program = publish::read_player_part("ugoki_player");
    if (!program) return fail(program.error());
    return ApiReply{200, text_of(publish::append_payload(std::as_bytes(std::span(*program)), *page, ugx)), "application/octet-stream"};
  }
  if (form != "glb" && form != "usda" && form != "csv")
    return fail(ErrorCode::unknown, "/api/export", "'" + std::string(form) + "' is not a form of export.",
                "Use html, native, ugx, glb, usda or csv.");
  const Result<publish::Take> take = publish::record_take(*player, player->content().duration, player->content().frame_rate);
  if (!take) return fail(take.error());
  if (form == "glb") return ApiReply{200, text_of(publish::write_take_glb(*take)), "application/octet-stream"};
  return ApiReply{200, form == "usda" ? publish::write_take_usda(*take) : publish::write_take_csv(*take), "application/octet-stream"};
}

}  // namespace ugoki::studio
