#include "ugoki/base/result.h"

namespace ugoki {

std::string Problem::text() const {
  std::string out = location.empty() ? message : location + ": " + message;
  if (!remedy.empty()) out += " " + remedy;
  return out;
}

std::string Error::text() const {
  std::string out;
  for (const Problem& p : problems) {
    if (!out.empty()) out += '\n';
    out += p.text();
  }
  return out;
}

}  // namespace ugoki
