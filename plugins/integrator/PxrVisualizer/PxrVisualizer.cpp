// PxrVisualizer: shows geometry without light: shaded by its angle to the view, by a headlight through its material,
// in a flat colour of its own, or as its normals, texture coordinates or a sphere map ("matcap"). Edges of
// micropolygons are drawn over it from the hit's barycentric coordinates; the triangle's shape is not known here, so
// that widths are those of an equilateral triangle of the same area.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrVisualizer/PxrVisualizer.cpp"
#include <kinora/named_values.h>
#include <cmath>
#include <memory>
#include <kinora/integrator_author.h>
#include <kinora/camera_hits.h>

#if KINORA_PLAIN
namespace kinora::pxrVisualizer {
constexpr std::array kParams = {
    param::string("style", "shaded")
        .options("bxdf|shaded|flat|normals|objectnormals|st|matcap")
        .help("What is shown: the material under a headlight, the angle to the view, a colour for each object, "
              "normals in world or object space, texture coordinates, or matCap."),
    param::onOff("wireframe", true).help("Draw the edges of micropolygons."),
    param::color("wireframeColor", 0.f).help("Of the edges."),
    param::number("wireframeOpacity", 0.5f).help("Of the edges."),
    param::number("wireframeWidth", 1.f).range(0, 10).help("Of the edges, pixels."),
    param::onOff("normalCheck", false).help("Orange where the inside is seen."),
    param::onOff("normalMap", false).help("Normals from -1 to 1 are shown as 0 to 1."),
    param::string("matCap", "").help("Image of a lit sphere, looked up by the normal in camera space."),
    param::string("shadedPrimVar", "displayColor")
        .help("Colour primvar that tints the style shaded; objects without it are white."),
};
enum class Style { Bxdf, Shaded, Flat, Normals, ObjectNormals, St, MatCap };
struct Data {
  Style style = Style::Shaded;
  bool wireframe = true, normalCheck = false, normalMap = false;
  float color[3] = {0, 0, 0}, opacity = 0.5f, width = 1;
  std::string tint;
  const HostImage* matCap = nullptr;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  auto k = std::make_unique<Data>();
  static constexpr const char* kStyles[] = {"bxdf", "shaded", "flat", "normals", "objectnormals", "st", "matcap"};
  const std::string style = v.string("style");
  bool found = false;
  for (size_t i = 0; i < std::size(kStyles); ++i)
    if (style == kStyles[i]) {
      k->style = Style(i);
      found = true;
    }
  if (!found)
    v.warn("PARAM-CHOICE",
           "style '" + style + "' is not one of bxdf, shaded, flat, normals, objectnormals, st, matcap",
           "shaded is used");
  k->wireframe = v.integer("wireframe") != 0;
  k->normalCheck = v.integer("normalCheck") != 0;
  k->normalMap = v.integer("normalMap") != 0;
  for (int c = 0; c < 3; ++c) k->color[c] = float(v.number("wireframeColor", c));
  k->opacity = float(std::fmin(1, std::fmax(0, v.number("wireframeOpacity"))));
  k->width = float(std::fmax(0, v.number("wireframeWidth")));
  k->tint = v.string("shadedPrimVar");
  const std::string file = v.string("matCap");
  if (k->style == Style::MatCap && info.host && info.host->image) {
    k->matCap = file.empty() ? nullptr : info.host->image(info.host->self, file.c_str(), -1);
    if (k->matCap && (!k->matCap->pixels || !k->matCap->width || !k->matCap->height || !k->matCap->channels))
      k->matCap = nullptr;
  }
  // files that cannot be read are told by the host
  if (k->style == Style::MatCap && file.empty())
    v.warn("PARAM-IMAGE", "style matcap shows an image, and matCap names none", "surfaces are white");
  return k;
}
}  // namespace kinora::pxrVisualizer
#endif

KINORA_KERNELS_BEGIN
using namespace pxrVisualizer;

struct PxrVisualizer {
  using Data = pxrVisualizer::Data;
  // x by a matrix's linear part (row vectors), or by its transpose for normals.
  static void turn(const MatrixValue& m, uint32_t point, bool transposed, float v[3]) {
    const uint32_t at = m.stride ? point : 0;
    float r[3];
    for (int k = 0; k < 3; ++k)
      r[k] = transposed ? v[0] * m.m[4 * k][at] + v[1] * m.m[4 * k + 1][at] + v[2] * m.m[4 * k + 2][at]
                        : v[0] * m.m[k][at] + v[1] * m.m[4 + k][at] + v[2] * m.m[8 + k][at];
    const float l = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    const float scale = l > 0 ? sqrt(Float<1>(1.f / l)).lane0() : 0.f;
    for (int k = 0; k < 3; ++k) v[k] = r[k] * scale;
  }

  template <int W>
  static void headlight(const CameraHits& hits, const Context& c, float* const rgb[3]) {
    EvaluateArgs e{};
    for (int x = 0; x < 3; ++x) e.wi[x] = c.wo[x];
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (int x = 0; x < 3; ++x) e.weight[l][x] = hits.floats(c.padded);
    e.pdf = hits.floats(c.padded);
    c.bxdf->evaluate(&c, c.closure, &e);
    float* glow[3] = {hits.floats(c.padded), hits.floats(c.padded), hits.floats(c.padded)};
    if (c.bxdf->emission) c.bxdf->emission(&c, c.closure, glow);
    for (uint32_t i = 0; i < c.padded; i += W)
      for (int x = 0; x < 3; ++x) {
        Float<W> sum(0.f);
        for (uint32_t l = 0; l < c.slotCount; ++l) sum += Float<W>::load(e.weight[l][x] + i);
        sum *= Float<W>(kPi);
        if (c.bxdf->emission) sum += Float<W>::load(glow[x] + i);
        sum.store(rgb[x] + i);
      }
  }

  static void matCap(const HostImage& image, float nx, float ny, float rgb[3]) {
    const auto texel = [](float x, uint32_t size) {
      const int i = int((0.5f + 0.5f * x) * float(size));
      return uint32_t(i < 0 ? 0 : i >= int(size) ? int(size) - 1 : i);
    };
    const float* p =
        image.pixels + (size_t(texel(-ny, image.height)) * image.width + texel(nx, image.width)) * image.channels;
    for (uint32_t k = 0; k < 3; ++k) rgb[k] = p[image.channels >= 3 ? k : 0];
  }

  template <int W>
  static void color(const Data& k, const CameraHits& hits, const Context& c, float* const rgb[3]) {
    if (k.style == Style::Bxdf) return headlight<W>(hits, c, rgb);
    MatrixValue m{};
    const char* space = k.style == Style::MatCap ? "camera" : k.style == Style::ObjectNormals ? "object" : "world";
    // normals go with the transpose of the way back
    const bool moved = (k.style == Style::Normals || k.style == Style::ObjectNormals || k.style == Style::MatCap) &&
                       c.fn->matrix(&c, space, "render", &m) != 0;
    const Value st = k.style == Style::St ? c.builtin(Builtin::St) : Value();
    const Value id = k.style == Style::Flat ? c.builtin(Builtin::ObjectId) : Value();
    Value tint;
    if (k.style == Style::Shaded && !k.tint.empty()) tint = c.fn->primvar(&c, k.tint.c_str(), nullptr);
    for (uint32_t i = 0; i < c.padded; ++i) {
      float n[3] = {c.N[0][i], c.N[1][i], c.N[2][i]}, out[3] = {1, 1, 1};
      const float facing = n[0] * c.wo[0][i] + n[1] * c.wo[1][i] + n[2] * c.wo[2][i];
      if (moved) turn(m, i, true, n);
      switch (k.style) {
        case Style::Bxdf:
          break;
        case Style::Shaded:
          for (uint32_t x = 0; x < 3; ++x)
            out[x] = facing * (tint.components >= 3 ? tint.data[x][tint.stride ? i : 0] : 1.f);
          break;
        case Style::Flat: {
          // three bytes of a hash of the object's number (or, where it has none, of its instance)
          const float number = id.components ? id.data[0][id.stride ? i : 0] : 0.f;
          uint32_t h = (number != 0 ? uint32_t(int32_t(number)) : c.place.instance[i]) * 0x9E3779B9u + 0x7feb352du;
          h = (h ^ h >> 15) * 0x846ca68bu;
          h ^= h >> 16;
          for (int x = 0; x < 3; ++x) out[x] = 0.15f + 0.75f * float(h >> (8 * x) & 255u) / 255.f;
          break;
        }
        case Style::Normals:
        case Style::ObjectNormals:
          for (int x = 0; x < 3; ++x) out[x] = k.normalMap ? 0.5f + 0.5f * n[x] : n[x];
          break;
        case Style::St:
          for (uint32_t x = 0; x < 2; ++x) {
            const float v = st.data[x][st.stride ? i : 0];
            out[x] = v - std::floor(v);
          }
          out[2] = 0;
          break;
        case Style::MatCap:
          if (k.matCap) matCap(*k.matCap, n[0], n[1], out);
          break;
      }
      // the side that the surface's own normal does not point to
      if (k.normalCheck && !c.entering[i]) {
        out[0] = 1 * facing;
        out[1] = 0.4f * facing;
        out[2] = 0;
      }
      for (int x = 0; x < 3; ++x) rgb[x][i] = out[x];
    }
  }

  static void wires(const Data& k, const Group& g, const CameraHits&, const Context& c, float* const rgb[3]) {
    MatrixValue m{};
    const bool known = c.fn->matrix(&c, "object", "render", &m) != 0;
    for (uint32_t i = 0; i < c.padded; ++i) {
      const uint32_t s = c.path[i < c.count ? i : c.count - 1], at = known && m.stride ? i : 0;
      const float b1 = c.place.u[i], b2 = c.place.v[i], b0 = 1 - b1 - b2,
                  b = b0 < b1 ? (b0 < b2 ? b0 : b2) : (b1 < b2 ? b1 : b2);
      const float ng2 = g.paths.hits.ng[0][s] * g.paths.hits.ng[0][s] +
                        g.paths.hits.ng[1][s] * g.paths.hits.ng[1][s] + g.paths.hits.ng[2][s] * g.paths.hits.ng[2][s];
      // |Ng| is twice the triangle's area: height of the equilateral one, sqrt(sqrt(3) area)
      float height = sqrt(Float<1>(0.8660254f * sqrt(Float<1>(ng2)).lane0())).lane0();
      if (known) {
        const float x = m.m[0][at], y = m.m[1][at], z = m.m[2][at];
        height *= sqrt(Float<1>(x * x + y * y + z * z)).lane0();
      }
      const float pixel = 2 * c.radius[i];
      if (!(height > 0) || !(pixel > 0) || b * height > 0.5f * k.width * pixel) continue;
      for (int x = 0; x < 3; ++x) rgb[x][i] += (k.color[x] - rgb[x][i]) * k.opacity;
    }
  }

  template <int W>
  static void integrate(const Data& k, uint32_t, Group& group, const Services& services) {
    const CameraHits hits(&group, &services);
    hits.showAll([&](const Context& c, float* const rgb[3]) {
      color<W>(k, hits, c, rgb);
      if (k.wireframe) wires(k, group, hits, c, rgb);
    });
  }
};

KINORA_KERNELS_END

KINORA_INTEGRATOR(PxrVisualizer,
                  .help = "Shows geometry without light: shading by the view, normals, texture coordinates, edges.",
                  .params = kParams, .setUp = setUpBy<make>)
