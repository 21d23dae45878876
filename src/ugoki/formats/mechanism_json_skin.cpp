#include "ugoki/formats/mechanism_json_skin.h"

#include <cstring>

#include "ugoki/base/base64.h"
#include "ugoki/base/number.h"
#include "ugoki/json/json.h"

namespace ugoki::formats {
namespace {

using json::Fields;
using json::Json;

template <class T>
std::string packed(const std::vector<T>& values) {
  return "\"" + to_base64({reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)}) + "\"";
}

template <class T>
void read_packed(Fields& f, std::string_view key, std::vector<T>& out) {
  std::string text;
  f.require(key, "packed numbers, a Base64 text");
  f.text(key, text);
  const std::optional<std::vector<std::uint8_t>> bytes = from_base64(text);
  if (!bytes || bytes->size() % sizeof(T) != 0)
    return f.report(ErrorCode::syntax, f.path(key), "The packed numbers are not valid Base64 or are incomplete.",
                    "Write the file again, or remove \"skin\".");
  out.resize(bytes->size() / sizeof(T));
  if (!out.empty()) std::memcpy(out.data(), bytes->data(), bytes->size());
}

/// Calls `read` for each object of the list `key`.
template <class Read>
void read_objects(Fields& f, std::string_view key, std::size_t maximum, const Read& read) {
  const Json* list = f.list(key, maximum, key);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    Fields g((*list)[i], f.path(key) + "/" + std::to_string(i), f.problems());
    if (!g.is_object()) continue;
    read(g);
    g.refuse_others();
  }
}

void read_part(Fields& f, SkinPart& part) {
  int first = 0, count = 0;
  f.text("color", part.color);
  f.integer("texture", part.texture);
  f.integer("first", first);
  f.integer("count", count);
  f.number("cutoff", part.cutoff);
  f.boolean("both_sides", part.both_sides);
  if (first < 0 || count < 0)
    f.report(ErrorCode::range, f.path(), "The range of the triangles is negative.", "Write the file again, or remove \"skin\".");
  bool good = part.color.size() == 7 && part.color[0] == '#';
  for (std::size_t i = 1; good && i < 7; ++i) good = std::string_view("0123456789abcdefABCDEF").contains(part.color[i]);
  if (!good) f.report(ErrorCode::syntax, f.path("color"), "The value is not a colour.", "Give it as \"#rrggbb\".");
  part.texture = std::max(part.texture, -1);
  part.first = static_cast<std::uint32_t>(std::max(first, 0));
  part.count = static_cast<std::uint32_t>(std::max(count, 0));
}

void read_bone(Fields& f, SkinBone& bone) {
  f.text("link", bone.link);
  double m[12];
  if (!f.numbers("matrix", m)) return;
  bone.A = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
  bone.p = {m[3], m[7], m[11]};
}

}  // namespace

void read_skin(Fields& document, MechanismSpec& spec) {
  const Json* object = document.find("skin");
  if (!object) return;
  Fields f(*object, document.path("skin"), document.problems());
  if (!f.is_object()) return;
  auto skin = std::make_shared<Skin>();
  read_packed(f, "positions", skin->positions);
  read_packed(f, "normals", skin->normals);
  read_packed(f, "uvs", skin->uvs);
  if (f.find("colors") != nullptr) read_packed(f, "colors", skin->colors);
  read_packed(f, "bones", skin->bones);
  read_packed(f, "weights", skin->weights);
  read_packed(f, "indices", skin->indices);
  read_objects(f, "parts", max_skin_parts, [&](Fields& g) { read_part(g, skin->parts.emplace_back()); });
  read_objects(f, "textures", max_skin_parts, [&](Fields& g) {
    SkinTexture& texture = skin->textures.emplace_back();
    g.text("type", texture.type);
    read_packed(g, "data", texture.data);
  });
  read_objects(f, "links", max_skin_bones, [&](Fields& g) { read_bone(g, spec.skin_bones.emplace_back()); });
  f.refuse_others();
  spec.skin = std::move(skin);
}

std::string skin_text(const Skin& skin, std::span<const SkinBone> bones) {
  std::string out = ",\n  \"skin\": {\n    \"positions\": " + packed(skin.positions) + ",\n    \"normals\": " + packed(skin.normals) +
                    ",\n    \"uvs\": " + packed(skin.uvs) + (skin.colors.empty() ? "" : ",\n    \"colors\": " + packed(skin.colors)) +
                    ",\n    \"bones\": " + packed(skin.bones) + ",\n    \"weights\": " + packed(skin.weights) +
                    ",\n    \"indices\": " + packed(skin.indices) + ",\n    \"parts\": [";
  for (const SkinPart& p : skin.parts) {
    out += &p == skin.parts.data() ? "\n      " : ",\n      ";
    out += "{\"color\": \"" + p.color + "\", \"texture\": " + std::to_string(p.texture) + ", \"first\": " + std::to_string(p.first) +
           ", \"count\": " + std::to_string(p.count);
    if (p.cutoff != 0) out += ", \"cutoff\": " + to_text(p.cutoff);
    if (p.both_sides) out += ", \"both_sides\": true";
    out += "}";
  }
  out += "],\n    \"textures\": [";
  for (const SkinTexture& t : skin.textures)
    out += (&t == skin.textures.data() ? "\n      " : ",\n      ") + ("{\"type\": \"" + t.type) + "\", \"data\": " + packed(t.data) + "}";
  out += "],\n    \"links\": [";
  for (const SkinBone& b : bones) {
    std::string numbers;
    for (int row = 0; row < 3; ++row) {
      const Vec3 r = b.A.row(row);
      for (const double x : {r.x, r.y, r.z, b.p[row]}) numbers += (numbers.empty() ? "" : ", ") + to_text(x);
    }
    out += (&b == bones.data() ? "\n      " : ",\n      ") + ("{\"link\": " + json::to_text(Json(b.link))) + ", \"matrix\": [" + numbers +
           "]}";
  }
  return out + "]\n  }";
}

}  // namespace ugoki::formats
