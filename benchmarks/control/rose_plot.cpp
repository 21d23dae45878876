#include "rose_plot.h"

#include <cstdarg>
#include <cstdio>

#include "ugoki/spatial/elementary.h"

namespace ugoki::bench {
namespace {

constexpr double size = 640, middle = 300, scale = 290;  // pixels; pixels per N s/kg

/// Appends formatted text.
__attribute__((format(printf, 2, 3))) void add(std::string& out, const char* format, ...) {
  char line[512];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  out += line;
}

struct Pixel {
  double x, y;
};
Pixel pixel(double impulse, double angle) {
  return {middle - scale * impulse * ugoki::sin(angle), middle - scale * impulse * ugoki::cos(angle)};
}

/// A published result that is drawn as an arc.
struct Published {
  double impulse, angle;  // N s/kg, rad
  const char* colour;
};

}  // namespace

std::string rose_svg(std::span<const RosePoint> points) {
  std::string out;
  add(out, "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %g %g\" font-family=\"sans-serif\" font-size=\"13\">\n", size,
      size + 80);
  add(out, "<title>Push rose</title>\n<rect width=\"%g\" height=\"%g\" fill=\"#fff\"/>\n", size, size + 80);
  for (const double ring : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    add(out, "<circle cx=\"%g\" cy=\"%g\" r=\"%g\" fill=\"none\" stroke=\"#ccc\"/>\n", middle, middle, scale * ring);
    add(out, "<text x=\"%g\" y=\"%g\" fill=\"#666\">%.1f</text>\n", middle + 3, middle - scale * ring - 3, ring);
  }
  for (int i = 0; i < 8; ++i) {
    const Pixel end = pixel(1, pi * i / 4);
    add(out, "<line x1=\"%g\" y1=\"%g\" x2=\"%.1f\" y2=\"%.1f\" stroke=\"#eee\"/>\n", middle, middle, end.x, end.y);
  }
  // People pushed from the side while they walk: mean 0.52, maximum 0.83 N s/kg (626 trials of DeepPushRecovery). Lee, Kim, Lee (2010):
  // pushes ahead, back, and to both sides.
  for (const Published& p : {Published{0.52, pi / 2, "#d60"},
                             {0.52, -pi / 2, "#d60"},
                             {0.83, pi / 2, "#fb7"},
                             {0.83, -pi / 2, "#fb7"},
                             {0.72, 0, "#06c"},
                             {0.59, pi, "#06c"},
                             {0.36, pi / 2, "#06c"},
                             {0.47, -pi / 2, "#06c"}}) {
    const Pixel a = pixel(p.impulse, p.angle + pi / 8), b = pixel(p.impulse, p.angle - pi / 8);
    const double r = scale * p.impulse;
    add(out, "<path d=\"M%.1f %.1fA%.1f %.1f 0 0 1 %.1f %.1f\" fill=\"none\" stroke=\"%s\" stroke-width=\"4\"/>\n", a.x, a.y, r, r, b.x,
        b.y, p.colour);
  }
  for (const RosePoint& p : points) {
    const Pixel at = pixel(p.impulse, p.angle);
    const char* colour = p.survived == p.tries ? "#2a2" : 2 * p.survived >= p.tries ? "#cc0" : "#c22";
    add(out, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5\" fill=\"%s\" stroke=\"#333\"><title>%d of %d pushes survived</title></circle>\n", at.x,
        at.y, colour, p.survived, p.tries);
  }
  const char* legend[][2] = {{"#2a2", "the character survives all pushes (dot: one walk, one direction, several phases)"},
                             {"#cc0", "at least half of the pushes"},
                             {"#c22", "fewer than half of the pushes"},
                             {"#d60", "people, pushed from the side: mean (light: maximum)"},
                             {"#06c", "Lee, Kim, Lee (2010): controller with measured walk"}};
  double y = 2 * middle + 20;
  for (const auto& [colour, text] : legend) {
    add(out, "<rect x=\"20\" y=\"%g\" width=\"12\" height=\"12\" fill=\"%s\"/><text x=\"40\" y=\"%g\">%s</text>\n", y, colour, y + 11,
        text);
    y += 18;
  }
  add(out, "<text x=\"20\" y=\"24\">Impulse / body mass, N s/kg. Up: direction of the walk.</text>\n</svg>\n");
  return out;
}

}  // namespace ugoki::bench
