// What the renderer answers for a batch of points.
#include <algorithm>

#include "language/vm/scalar.h"

namespace kinora::language {

namespace {

constexpr uint32_t kMostOptions = 32;

void zero(const Call& call, uint32_t k) {
  eachLive(call, [&](uint32_t i) {
    for (uint32_t c = 0; c < call.cells(k); ++c) call.set(k, i, int32_t(0), c);
  });
}
// A uniform result with a uniform question is asked once.
Batch batchOf(const Call& call) { return call.batch(); }

// Arguments from `first` that are no strings: coordinates and their derivatives.
uint32_t numbersFrom(const Call& call, uint32_t first) {
  uint32_t end = first;
  while (end < call.count() && (call.base(end) != Base::String || call.isArray(end))) ++end;
  return end - first;
}

// One span of several arguments, which may vary apart from each other: then all are spread into scratch arrays.
struct Joined {
  float* cells[3];
  Span span;
  void add(const Call& call, uint32_t k, uint32_t& scratch, bool spread) {
    for (uint32_t c = 0; c < call.cells(k) && span.components < 3; ++c) {
      float* from = call.f.cells[call.argument(k)[0] + c];
      if (spread && !call.varies(k)) {
        float* to = call.f.run->scratch(scratch++);
        std::fill(to, to + call.f.points, from[0]);
        from = to;
      }
      cells[span.components++] = from;
    }
    span.varies = spread;
    span.base = uint8_t(Base::Float);
    span.cells = cells;
  }
};

}  // namespace

// site, found, matrix, from, to (plain operands), has a mask, [mask]
void scalarGetMatrix(const Frame& f, const uint32_t* w) {
  const RendererServices& services = *f.run->services;
  const bool masked = w[9] != 0;
  static const int32_t kCommon = internString("common"), kWorld = internString("world");
  float* other[16];
  float* single[16];
  for (uint32_t k = 0; k < 16; ++k) other[k] = f.run->scratch(k);
  float* const* out = f.cells + w[2];
  float* pointMask = f.run->scratch(16);
  const bool varies = w[5] || w[8];
  const auto identity = [&](float* const* m, uint32_t first, uint32_t n) {
    for (uint32_t k = 0; k < 16; ++k) std::fill_n(m[k] + first, n, k % 5 == 0 ? 1.f : 0.f);
  };
  const auto isCommon = [&](int32_t space) { return space == 0 || space == kCommon || space == kWorld; };
  const auto ask = [&](const Batch& batch, int32_t space, bool toCommon, float* const* m) {
    if (isCommon(space)) return true;
    const auto call = toCommon ? services.spaceToCommon : services.commonToSpace;
    Span span;
    span.cells = m;
    span.components = 16;
    span.base = uint8_t(Base::Matrix);
    span.varies = true;
    return call && call(services.self, batch, space, span);
  };
  // null where it is known
  const auto unknown = [&](uint32_t i, const int32_t* from, const int32_t* to) {
    setInt(f.cells[w[1]], i, 0);
    identity(out, i, 1);
    if (f.run->toldOnce[w[0]] && !f.run->tellsEveryPoint) return;
    const Executable& e = *f.run->program;
    f.run->toldOnce[w[0]] = 1;
    for (const int32_t* space : {from, to})
      if (space && (space == from || !from || *space != *from))
        f.run->say(f.first + i, MessageKind::Error,
                   "Unknown transformation \"" + stringOf(*space) + "\": " + placeOf(e, SiteAccess::site(e, w[0])));
  };
  for (uint32_t first = 0; first < f.points; ++first) {
    // all points at once where they ask for the same spaces, else one after the other
    const uint32_t n = varies ? 1 : f.points;
    if (varies && masked && !takesPart(f, w[10], first)) continue;
    const int32_t from = intAt(f.cells[w[3]], w[5] ? first : 0), to = intAt(f.cells[w[6]], w[8] ? first : 0);
    // most ask for the way to or from "common", and nothing is multiplied
    const bool isProduct = !isCommon(from) && !isCommon(to);
    identity(out, first, n);
    if (isProduct) identity(other, first, n);
    for (uint32_t i = first; i < first + n; ++i) {
      setInt(f.cells[w[1]], i, 1);
      setInt(pointMask, i, !masked || takesPart(f, w[10], i) ? -1 : 0);
    }
    Batch batch{n, f.first + first, reinterpret_cast<const int32_t*>(pointMask + first)};
    for (uint32_t k = 0; k < 16; ++k) single[k] = out[k] + first;
    const bool knowsFrom = ask(batch, from, true, single);
    for (uint32_t k = 0; k < 16; ++k) single[k] = (isProduct ? other : out)[k] + first;
    const bool knowsTo = ask(batch, to, false, single);
    for (uint32_t i = first; (isProduct || !knowsFrom || !knowsTo) && i < first + n; ++i) {
      if (masked && !takesPart(f, w[10], i)) continue;
      if (!knowsFrom || !knowsTo) {
        unknown(i, knowsFrom ? nullptr : &from, knowsTo ? nullptr : &to);
        continue;
      }
      float product[16];
      for (uint32_t row = 0; row < 4; ++row)
        for (uint32_t c = 0; c < 4; ++c) {
          float sum = out[4 * row][i] * other[c][i];
          for (uint32_t k = 1; k < 4; ++k) sum += out[4 * row + k][i] * other[4 * k + c][i];
          product[4 * row + c] = sum;
        }
      for (uint32_t k = 0; k < 16; ++k) out[k][i] = product[k];
    }
    if (!varies) break;
  }
}

// found, [object,] name, [index,] destination
void scalarGetAttribute(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  zero(call, 0);
  const uint32_t last = call.count() - 1;
  Span object, index;
  uint32_t name = 1;
  if (call.count() == 5 || (call.count() == 4 && call.base(2) == Base::String)) object = call.span(1), name = 2;
  if (name + 1 < last) index = call.span(name + 1);
  // what the program knows of itself
  if (object.components == 0 && index.components == 0 && !call.varies(name)) {
    const std::string& asked = call.text(name, 0);
    const Executable& e = *f.run->program;
    const std::string* answer = asked == "shader:shadername"  ? &SiteAccess::shader(e, call.site().layer)
                                : asked == "shader:layername" ? &SiteAccess::layer(e, call.site().layer)
                                : asked == "shader:groupname" ? &e.group()
                                                              : nullptr;
    if ((answer && call.base(last) == Base::String) || (asked == "osl:version" && call.base(last) == Base::Int)) {
      const int32_t value = answer ? internString(*answer) : 11400;
      eachLive(call, [&](uint32_t i) {
        call.set(0, i, int32_t(1));
        call.set(last, i, value);
      });
      return;
    }
  }
  if (f.run->services->getAttribute)
    f.run->services->getAttribute(f.run->services->self, batchOf(call), object, call.span(name), index,
                                  call.span(last), call.span(0));
}
void scalarRayType(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  zero(call, 0);
  if (f.run->services->rayType)
    f.run->services->rayType(f.run->services->self, batchOf(call), call.span(1), call.span(0));
}
void scalarBackfacing(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  zero(call, 0);
  if (f.run->services->backfacing) f.run->services->backfacing(f.run->services->self, batchOf(call), call.span(0));
}
void scalarSurfaceArea(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  zero(call, 0);
  if (f.run->services->surfaceArea) f.run->services->surfaceArea(f.run->services->self, batchOf(call), call.span(0));
}

// result, file, s, t [, dsdx, dtdx, dsdy, dtdy], options; texture3d and environment: a triple [, its derivatives]
void scalarTexture(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  const TextureKind kind = TextureKind(call.extra());
  const RendererServices& services = *f.run->services;
  zero(call, 0);
  TextureCall t;
  t.result = call.span(0);
  const auto zeroDerivs = [&](uint32_t k, Span& dx, Span& dy) {
    dx = call.derivs(k, 1);
    dy = call.derivs(k, 2);
    for (const Span* d : {&dx, &dy})
      for (uint32_t c = 0; c < d->components; ++c)
        for (uint32_t i = 0; i < f.points; ++i)
          if (call.isLive(i)) d->set(c, i, 0.f);
  };
  zeroDerivs(0, t.resultDx, t.resultDy);
  t.file = call.span(1);
  const uint32_t numbers = numbersFrom(call, 2);
  const uint32_t own = kind == TextureKind::Texture ? 2 : 1;  // arguments that are the coordinates
  bool spread = false;
  for (uint32_t k = 2; k < 2 + numbers; ++k) spread |= call.varies(k);
  uint32_t scratch = 0;
  Joined place, dx, dy, dz;
  for (uint32_t k = 0; k < own && k < numbers; ++k) place.add(call, 2 + k, scratch, spread);
  if (numbers > own) {
    Joined* const along[3] = {&dx, &dy, &dz};
    for (uint32_t k = own; k < numbers; ++k) along[std::min((k - own) / own, 2u)]->add(call, 2 + k, scratch, spread);
  } else if (spread) {
    Joined* const along[2] = {&dx, &dy};
    for (uint32_t axis = 0; axis < 2; ++axis)
      for (uint32_t k = 0; k < own; ++k) {
        const Span d = call.derivs(2 + k, axis + 1);
        Joined& to = *along[axis];
        for (uint32_t c = 0; c < call.cells(2 + k) && to.span.components < 3; ++c) {
          float* from = d.components ? d.cells[c] : nullptr;
          if (!from) {
            from = f.run->scratch(scratch++);
            std::fill(from, from + f.points, 0.f);
          }
          to.cells[to.span.components++] = from;
        }
        to.span.cells = to.cells;
        to.span.varies = true;
      }
  }
  t.coordinates = place.span;
  t.dx = dx.span;
  t.dy = dy.span;
  t.dz = dz.span;
  Span tokens[kMostOptions], values[kMostOptions];
  for (uint32_t k = 2 + numbers; k + 1 < call.count() && t.options < kMostOptions; k += 2) {
    if (!call.varies(k)) {
      const std::string& token = call.text(k, 0);
      if (token == "alpha" || token == "errormessage") {
        zero(call, k + 1);
        (token == "alpha" ? t.alpha : t.error) = call.span(k + 1);
        if (token == "alpha") zeroDerivs(k + 1, t.alphaDx, t.alphaDy);
        continue;
      }
    }
    tokens[t.options] = call.span(k);
    values[t.options++] = call.span(k + 1);
  }
  t.tokens = tokens;
  t.values = values;
  const auto ask = kind == TextureKind::Texture     ? services.texture
                   : kind == TextureKind::Texture3d ? services.texture3d
                                                    : services.environment;
  if (ask) ask(services.self, batchOf(call), t);
}

// found, file, [s, t,] name, destination
void scalarGetTextureInfo(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  zero(call, 0);
  const uint32_t last = call.count() - 1;
  Joined place;
  uint32_t scratch = 0;
  if (last > 3)
    for (uint32_t k = 2; k < last - 1; ++k) place.add(call, k, scratch, call.varies(2) || call.varies(3));
  if (f.run->services->getTextureInfo)
    f.run->services->getTextureInfo(f.run->services->self, batchOf(call), call.span(1), place.span,
                                    call.span(last - 1), call.span(last), call.span(0));
}

// hit, position, direction, options
void scalarTrace(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  zero(call, 0);
  Span tokens[kMostOptions], values[kMostOptions];
  uint32_t options = 0;
  for (uint32_t k = 3; k + 1 < call.count() && options < kMostOptions; k += 2) {
    tokens[options] = call.span(k);
    values[options++] = call.span(k + 1);
  }
  if (f.run->services->trace)
    f.run->services->trace(f.run->services->self, batchOf(call), call.span(1), call.span(2), tokens, values, options,
                           call.span(0));
}

// found, source, name, destination
void scalarGetMessage(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  zero(call, 0);
  if (f.run->services->getMessage)
    f.run->services->getMessage(f.run->services->self, batchOf(call), call.span(1), call.span(2), call.span(3),
                                call.span(0));
}

}  // namespace kinora::language
