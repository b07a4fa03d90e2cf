// Lookups of OpenTextures, for the points of a group: what holds for all points of one file is found once, the rest is
// asked of the tiles of group_lookup.h, or of OpenImageIO's own call.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <numeric>

#include "image/colors.h"
#include "texture/footprint.h"
#include "texture/missing_color.h"
#include "texture/module/level_files.h"
#include "texture/module/open_textures.h"

namespace kinora::texture {
namespace {

TextureOpt::Wrap wrapOf(int code, TextureOpt::Wrap file) {
  switch (code) {
    case 0:
      return TextureOpt::WrapBlack;
    case 2:
      return TextureOpt::WrapClamp;
    case 3:
      return TextureOpt::WrapPeriodic;
    case 4:
      return TextureOpt::WrapMirror;
    default:
      return file;
  }
}
// OpenImageIO's bicubic is the cubic B-spline; a gaussian of PxrTexture's width is within a few percent of it. The
// box filter is the footprint's mip level itself (made by box filtering), read bilinearly.
TextureOpt::InterpMode interpolationOf(int code) {
  switch (code) {
    case 0:
      return TextureOpt::InterpClosest;
    case 3:
    case 6:
      return TextureOpt::InterpBicubic;
    case 7:
      return TextureOpt::InterpSmartBicubic;
    default:
      return TextureOpt::InterpBilinear;
  }
}

// Texture coordinates that fit OpenImageIO's integers and never are NaN. Periodic ones lose whole turns only.
inline float safeCoordinate(float x, TextureOpt::Wrap wrap) {
  constexpr float kLimit = 256.f;
  if (std::fabs(x) <= kLimit) return x;
  if (!std::isfinite(x)) return 0.f;
  if (wrap == TextureOpt::WrapPeriodic) return x - std::floor(x);
  if (wrap == TextureOpt::WrapMirror) return std::fmod(x, 2.f);
  return std::clamp(x, -kLimit, kLimit);
}
inline float safeRadius(float r, float blur) {
  const float x = r + blur;
  return x > 0.f ? std::min(x, 4.f) : 0.f;  // NaN gives 0
}

bool isSimple(TextureOpt::Wrap w, texture::Wrap& out) {
  if (w != TextureOpt::WrapBlack && w != TextureOpt::WrapClamp && w != TextureOpt::WrapPeriodic) return false;
  out = w == TextureOpt::WrapBlack   ? texture::Wrap::Black
        : w == TextureOpt::WrapClamp ? texture::Wrap::Clamp
                                     : texture::Wrap::Periodic;
  return true;
}

}  // namespace

Cache::TextureHandle* OpenTextures::plain(Source& s) {
  if (Cache::TextureHandle* h = s.plain.load(std::memory_order_acquire)) return h;
  const std::lock_guard one(s.making);
  if (Cache::TextureHandle* h = s.plain.load(std::memory_order_acquire)) return h;
  const OIIO::ustring name(s.facts.path);
  addPooledFile(*cache->imagecache(), name, pace, false);
  Cache::TextureHandle* h = cache->get_texture_handle(name);
  s.plain.store(h, std::memory_order_release);
  return h;
}

Cache::TextureHandle* OpenTextures::decoded(Source& s) {
  if (Cache::TextureHandle* h = s.decoded.load(std::memory_order_acquire)) return h;
  const std::lock_guard one(s.making);
  if (Cache::TextureHandle* h = s.decoded.load(std::memory_order_acquire)) return h;
  // TIFF does not record that colours are light, so that the type of the numbers is all there is to judge by
  if (s.facts.format.is_floating_point() && !image::Colors::ofEnvironment().isManaged())
    diagnostics.info("ASSET-TEXTURE-DECODED", s.pos,
                     "texture '" + s.facts.path +
                         "' holds floating-point numbers, which are light already in most files (maketex --linearize "
                         "makes such), and linearize 1 decodes them from sRGB once more; for light use linearize 0");
  const OIIO::ustring name(texture::kSrgbPrefix + s.facts.path);
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);
  addPooledFile(*cache->imagecache(), name, pace, true, config);
  Cache::TextureHandle* h = cache->get_texture_handle(name);
  s.decoded.store(h, std::memory_order_release);
  return h;
}

Cache::TextureHandle* OpenTextures::withLevels(Source& s, bool linearize) {
  std::atomic<Cache::TextureHandle*>& known = s.withLevels[linearize];
  if (Cache::TextureHandle* h = known.load(std::memory_order_acquire)) return h;
  std::lock_guard lock(mutex);
  if (Cache::TextureHandle* h = known.load(std::memory_order_acquire)) return h;
  Cache::TextureHandle* h = cache->get_texture_handle(levels->add(nameInCache(s, linearize)));
  known.store(h, std::memory_order_release);
  return h;
}

bool OpenTextures::describeKept(texture::Pyramid& p, const Source& s, const std::string& folder, OIIO::ustring finest,
                                OIIO::ustring coarse, OIIO::ImageCache::Perthread* thread) {
  // a picture that has none, or whose parts have, is as fast without
  if (s.facts.width < 2 && s.facts.height < 2) return false;
  OIIO::ImageCache& images = *cache->imagecache();
  texture::LevelFiles files;
  std::string why;
  try {
    why = texture::keepLevels(images, thread, folder, s.facts.path, finest, coarse, files);
    if (why.empty())
      for (const std::string& file : {files.finest, files.coarser})
        addPooledFile(images, OIIO::ustring(file), pace, false);
    if (why.empty() && p.describe(images, thread, OIIO::ustring(files.finest), OIIO::ustring(files.coarser), true))
      return true;
    if (why.empty()) why = firstLine(images.geterror());
  } catch (const std::exception& e) {
    why = e.what();
  }
  diagnostics.warning("ASSET-TEXTURE-FOLDER", s.pos,
                      "levels of texture '" + s.facts.path + "' cannot be kept in '" + folder + "': " + why,
                      "they are made while rendering", "a folder that can be written, with room: --texture-folder");
  return false;
}

const texture::Pyramid& OpenTextures::levelsOf(Source& s, bool linearize, OIIO::ImageCache::Perthread* thread) {
  std::atomic<const texture::Pyramid*>& known = linearize ? s.decodedLevels : s.plainLevels;
  if (const texture::Pyramid* p = known.load(std::memory_order_acquire)) return *p;
  const std::lock_guard one(s.making);  // other files need not wait for those of this one
  if (const texture::Pyramid* p = known.load(std::memory_order_acquire)) return *p;
  auto made = std::make_unique<texture::Pyramid>();
  OIIO::ImageCache& images = *cache->imagecache();
  const OIIO::ustring name(nameInCache(s, linearize));
  OIIO::ustring coarse = name;
  std::string folder;
  {
    const std::lock_guard lock(mutex);
    if (!s.facts.mipMapped) coarse = levels->add(name.string());
    folder = levelFolder;
  }
  const OIIO::ustring finest = s.facts.cropped ? coarse : name;
  if (s.facts.mipMapped || folder.empty() || !describeKept(*made, s, folder, finest, coarse, thread))
    if (!made->describe(images, thread, finest, coarse)) made->levels.clear();
  const std::lock_guard lock(mutex);
  s.held[linearize] = std::move(made);
  known.store(s.held[linearize].get(), std::memory_order_release);
  return *s.held[linearize];
}

void OpenTextures::bind(Bound& b, Source* s, const TextureOptions& o, const Part& part, bool atlas,
                        OIIO::ImageCache::Perthread* thread) {
  b.source = s;
  b.handle = o.linearize ? decoded(*s) : plain(*s);
  const int available = s->facts.channels - std::max(o.firstChannel, 0);
  b.channels = std::clamp(available, 0, 4);
  b.opt.firstchannel = std::max(o.firstChannel, 0);
  b.opt.swrap = atlas ? TextureOpt::WrapClamp : wrapOf(o.wrapS, s->wrapS);
  b.opt.twrap = atlas ? TextureOpt::WrapClamp : wrapOf(o.wrapT, s->wrapT);
  b.opt.interpmode = interpolationOf(o.filter);
  // the library chooses between cubic and linear only in the mode that would be anisotropic, which at most 1 is not
  const bool isSmart = b.opt.interpmode == TextureOpt::InterpSmartBicubic;
  b.opt.mipmode = !o.interpolateLevels ? TextureOpt::MipModeOneLevel
                  : isSmart            ? TextureOpt::MipModeAniso
                                       : TextureOpt::MipModeTrilinear;
  b.opt.anisotropic = 1;
  b.levels = nullptr;
  b.opt.subimage = std::max(part.number, 0);
  b.opt.subimagename = part.name.empty() ? OIIO::ustring() : OIIO::ustring(std::string(part.name));
  const bool isFirst = part.number <= 0 && part.name.empty();
  if (isFirst && b.channels > 0 && (b.opt.interpmode == TextureOpt::InterpBilinear || isSmart) &&
      isSimple(b.opt.swrap, b.kind.wrapS) && isSimple(b.opt.twrap, b.kind.wrapT)) {
    const texture::Pyramid& levels = levelsOf(*s, o.linearize != 0, thread);
    if (!levels.levels.empty()) b.levels = &levels;
    b.kind.blendLevels = o.interpolateLevels != 0;
    b.kind.isCubic = isSmart;
    b.kind.firstChannel = b.opt.firstchannel;
    b.kind.channels = b.channels;
  }
  b.width = b.levels ? b.levels->levels[0].width : std::max(s->facts.width, 1);
  b.height = b.levels ? b.levels->levels[0].height : std::max(s->facts.height, 1);
  if (!b.levels && (!s->facts.mipMapped || !isFirst)) b.handle = withLevels(*s, o.linearize != 0);
  if (b.channels == 0 && !s->complained.exchange(true))
    diagnostics.warning("ASSET-TEXTURE-CHANNEL", s->pos,
                        "texture '" + s->facts.path + "' has " + std::to_string(s->facts.channels) +
                            " channels, the first one asked for is " + std::to_string(o.firstChannel),
                        "lookups give the missing colour");
}

void OpenTextures::complain(Source& s, std::string why) {
  why = firstLine(std::move(why));
  if (why.empty()) why = firstLine(cache->geterror());
  if (why.empty()) why = firstLine(cache->imagecache()->geterror());
  if (s.complained.exchange(true)) return;
  diagnostics.warning(
      "ASSET-TEXTURE-READ", s.pos,
      "texture '" + s.facts.path + "'" + (s.object.empty() ? "" : " of " + s.object) + " is damaged: " + why,
      "its unreadable parts give the missing colour");
}

void OpenTextures::complainOfHole(Atlas& a) {
  if (a.complained.exchange(true)) return;
  const std::string holes = a.holes();
  diagnostics.warning("ASSET-TEXTURE-TILE", a.pos,
                      a.name + " is looked up at a tile that has no file" +
                          (holes.empty() ? " (outside of those that it has)" : " (there is none for " + holes + ")"),
                      "lookups there give the missing colour",
                      "add the files, or keep the texture coordinates inside the set");
}

void OpenTextures::sortByFile(OfThread& own, const int32_t* handles, bool varying, uint32_t n) {
  own.order.resize(n);
  if (!varying) {
    std::iota(own.order.begin(), own.order.end(), 0u);
    return;
  }
  constexpr uint32_t kKeys = 256;
  uint32_t at[kKeys + 1] = {};
  for (uint32_t i = 0; i < n; ++i) ++at[uint32_t(handles[i]) % kKeys + 1];
  for (uint32_t k = 0; k < kKeys; ++k) at[k + 1] += at[k];
  for (uint32_t i = 0; i < n; ++i) own.order[at[uint32_t(handles[i]) % kKeys]++] = i;
}

void OpenTextures::lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t,
                          const float* radius, const TextureOptions& o, const Part& part, float* const rgba[4],
                          const float* const* axes) {
  Cache::Perthread* thread = cache->get_perthread_info();
  OIIO::ImageCache& images = *cache->imagecache();
  OIIO::ImageCache::Perthread* imageThread = images.get_perthread_info();
  OfThread& own = threads.local();
  if (!own.tiles) own.tiles = std::make_unique<texture::TileTable>(images, *readers);
  texture::TileTable& tiles = *own.tiles;
  tiles.enter(imageThread, tileBytes);
  sortByFile(own, handles, varying, n);
  Bound bound;
  uint64_t missing = 0;
  const texture::MissingColor missingColor(o);
  // of the texels that tiles are asked for
  struct Asker {
    uint32_t point, channels;
    float share;   // of what the point is given
    bool isFirst;  // of the point's probes, which come one after the other
  };
  Asker askers[texture::TileTable::kBlock];
  const auto put = [&](const Asker& to, const float texel[4]) {
    const uint32_t available = to.channels;
    const float values[4] = {texel[0], available >= 3 ? texel[1] : texel[0], available >= 3 ? texel[2] : texel[0],
                             available == 4   ? texel[3]
                             : available == 2 ? texel[1]
                                              : 1.f};
    for (int c = 0; c < 4; ++c) {
      float& sum = rgba[c][to.point];
      sum = to.isFirst ? values[c] * to.share : sum + values[c] * to.share;
    }
  };
  const auto answer = [&] {
    float texels[texture::TileTable::kBlock][4];
    const uint32_t count = tiles.asked();
    tiles.answer(texels);
    for (uint32_t k = 0; k < count; ++k) put(askers[k], texels[k]);
  };
  using Reply = TileTable::Reply;
  using When = TileTable::When;
  const Entry* entry = nullptr;
  int32_t handle = kNoTexture;
  const size_t known = entries.size();
  // False when the point is to be looked up once more, with the tiles that it lacks: all of it, so that its probes
  // are added in their order.
  const auto lookUp = [&](uint32_t i, When when) {
    if (const int32_t h = handles[varying ? i : 0]; h != handle) {
      handle = h;
      entry = h >= 0 && size_t(h) < known ? &entries[size_t(h)] : nullptr;
    }
    Source* source = entry ? entry->single : nullptr;
    float si = s[i], ti = t[i];
    const bool atlas = entry && entry->atlas;
    if (atlas) {
      // t counts down from the top of the first row; rows of an atlas count up
      float up = 1.f - ti;
      source = entry->atlas->find(si, up);
      ti = 1.f - up;
      if (!source) complainOfHole(*entry->atlas);
    }
    bool found = false;
    if (source) {
      if (source != bound.source) bind(bound, source, o, part, atlas, imageThread);
      if (bound.channels > 0) {
        texture::Probes probes;
        const float least = float(std::min(bound.width, bound.height));
        bool isEllipse = false;
        if (axes && bound.opt.interpmode != TextureOpt::InterpClosest) {
          const float axis[4] = {axes[0][i], axes[1][i], axes[2][i], axes[3][i]};
          isEllipse = texture::findProbes(axis, o.blur, bound.width, bound.height, probes);
        }
        const float r = isEllipse ? probes.texels / least : safeRadius(radius[i], o.blur);
        if (!isEllipse) probes.texels = r * least;
        const float x = safeCoordinate(si, bound.opt.swrap), y = safeCoordinate(ti, bound.opt.twrap);
        const texture::TileTable::LevelMix mix =
            bound.levels ? texture::TileTable::mixOf(*bound.levels, bound.kind, probes.texels)
                         : texture::TileTable::LevelMix();
        const float share = 1.f / float(probes.count);
        found = true;
        for (int k = 0; found && k < probes.count; ++k) {
          const Asker from{i, uint32_t(bound.channels), share, k == 0};
          const float xs = x + (probes.firstS + float(k) * probes.stepS),
                      yt = y + (probes.firstT + float(k) * probes.stepT);
          if (bound.levels) {
            if (tiles.isFull()) answer();
            askers[tiles.asked()] = from;
            const Reply reply = tiles.ask(*bound.levels, bound.kind, mix, xs, yt, when);
            if (reply == Reply::Awaited) when = When::Never;  // which tiles its other probes lack
            found = reply != Reply::Unreadable;
          } else {
            float texel[4];
            found = cache->texture(bound.handle, thread, bound.opt, xs, yt, r, 0.f, 0.f, r, bound.channels, texel);
            if (found) put(from, texel);
          }
        }
        if (found && when == When::Never) return false;
        if (!found) {
          complain(*source, tiles.reason());
          if (tiles.asked()) answer();  // probes of this point that could be read
        }
      }
    }
    if (found) return true;
    ++missing;
    float color[3];
    missingColor.at(s[i], t[i], safeRadius(radius[i], o.blur), color);
    for (int c = 0; c < 3; ++c) rgba[c][i] = color[c];
    rgba[3][i] = o.missingAlpha;
    return true;
  };
  own.later.clear();
  own.later.reserve(n);
  const TextureReading::Way way = readers->way();
  const bool isGathered = way == TextureReading::Measured ? tiles.isLagging() : way != TextureReading::OneByOne;
  const When first = isGathered ? When::Later : When::Now;
  const uint32_t *at = own.order.data(), *const last = at + n, *end = last, *resumed = at;
  // through the points, and before the end, or where tiles crowd, through those that were put aside
  for (When when = first;;) {
    while (at < end) {
      const uint32_t i = *at++;
      if (lookUp(i, when)) continue;
      own.later.push_back(i);
      if (tiles.isCrowded()) break;
    }
    if (tiles.asked()) answer();
    if (!own.later.empty() && when != When::Now) {
      tiles.fetch();
      resumed = at;
      at = own.later.data();
      end = at + own.later.size();
      when = When::Now;
    } else if (resumed < last && when != first) {
      tiles.settle();
      own.later.clear();
      at = resumed;
      end = last;
      when = first;
    } else {
      break;
    }
  }
  tiles.settle();
  lookups.fetch_add(n, std::memory_order_relaxed);
  if (missing) missingLookups.fetch_add(missing, std::memory_order_relaxed);
}

}  // namespace kinora::texture
