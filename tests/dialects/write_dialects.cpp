// Writes a motion file in all dialects: ugoki_dialects FILE FOLDER [SKELETON.asf].
#include <cstdio>
#include <string>

#include "dialects.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"

using namespace ugoki;

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: ugoki_dialects FILE.bvh|FILE.amc FOLDER [SKELETON.asf]\n");
    return 2;
  }
  const std::string path = argv[1], folder = argv[2];
  const auto text = files::read_file(path);
  if (!text) {
    std::fprintf(stderr, "%s\n", text.error().text().c_str());
    return 1;
  }
  Result<MeasuredMotion> motion = [&]() -> Result<MeasuredMotion> {
    if (!path.ends_with(".amc")) return formats::read_bvh(*text, path);
    const auto asf_text = files::read_file(argc > 3 ? argv[3] : "");
    if (!asf_text) return fail(asf_text.error());
    const auto asf = formats::read_asf(*asf_text, argv[3]);
    if (!asf) return fail(asf.error());
    return formats::read_amc(*text, path, *asf);
  }();
  if (!motion) {
    std::fprintf(stderr, "%s\n", motion.error().text().c_str());
    return 1;
  }
  int number = 0;
  for (const dialects::Dialect& d : dialects::all_dialects()) {
    std::string stem = (number < 10 ? "0" : "") + std::to_string(number) + "-" + d.name;
    ++number;
    for (char& c : stem)
      if (c == ' ') c = '-';
    const dialects::DialectFile file = dialects::write(dialects::rewrite(*motion, d), d, stem);
    if (!files::write_file(folder + "/" + file.name, file.bytes)) return 1;
    if (!file.asf.empty() && !files::write_file(folder + "/" + stem + ".asf", file.asf)) return 1;
  }
  return 0;
}
