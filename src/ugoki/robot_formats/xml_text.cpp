#include "ugoki/robot_formats/xml_text.h"

#include "ugoki/base/number.h"

namespace ugoki::robot_formats {

void XmlText::begin(std::string_view name, const std::string& attributes) {
  indent();
  ((text_ += '<') += name) += attributes + ">\n";
  open_.emplace_back(name);
}

void XmlText::end() {
  const std::string name = std::move(open_.back());
  open_.pop_back();
  indent();
  text_ += "</" + name + ">\n";
}

void XmlText::element(std::string_view name, const std::string& attributes) {
  indent();
  ((text_ += '<') += name) += attributes + "/>\n";
}

std::string attribute(std::string_view name, std::string_view value) {
  std::string out = " ";
  (out += name) += "=\"";
  for (const char c : value) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out + '"';
}
std::string attribute(std::string_view name, double value) { return attribute(name, std::string_view(to_text(value))); }
std::string attribute(std::string_view name, const Vec3& value) { return attribute(name, std::string_view(numbers(value))); }
std::string attribute(std::string_view name, const Quat& q) {
  return attribute(name, std::string_view(to_text(q.w) + ' ' + to_text(q.x) + ' ' + to_text(q.y) + ' ' + to_text(q.z)));
}
std::string numbers(const Vec3& v) { return to_text(v.x) + ' ' + to_text(v.y) + ' ' + to_text(v.z); }

}  // namespace ugoki::robot_formats
