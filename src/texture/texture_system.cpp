#include "texture/texture_system.h"

#include <atomic>
#include <mutex>
#include <optional>

#include "base/file_contents.h"
#include "image/picture_library.h"
#include "texture/missing_color.h"
#include "texture/texture_store.h"

#if defined(__SANITIZE_ADDRESS__)
// OpenImageIO 2.4's TextureSystem::destroy deletes with the wrong size, which ends every program of the asan build;
// harmless with glibc's allocator, and not ours to mend.
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "new_delete_type_mismatch=0"; }
#endif

namespace kinora {

using texture::TextureCalls;
using texture::TextureStore;

// Scenes without textures never have a store, and load no library for one.
struct TextureSystem::Impl {
  Impl(Diagnostics& d, FileContents* c) : diagnostics(d), contents(c) {}

  // Made when the first file is asked for; null with `why`.
  TextureStore* open(std::string& why) {
    if (TextureStore* const s = store) return s;
    const std::lock_guard lock(mutex);
    if (store) return store;
    const auto* const library = image::pictureLibrary<TextureCalls>(why);
    if (!library) return nullptr;
    owner = library->open(diagnostics, contents);
    owner->setSearchPath(searchPath);
    if (cacheLimit) owner->setCacheLimit(*cacheLimit);
    owner->setLevelFolder(levelFolder);
    owner->setReading(reading);
    store = owner.get();
    return store;
  }
  // open(), or a message and a note that the file is not there.
  TextureStore* openFor(const std::string& file, const TextureRequest& request, const char* done) {
    std::string why;
    if (TextureStore* const s = open(why)) return s;
    if (contents) contents->use("texture", file, std::vector<std::string>());
    diagnostics.warning("ASSET-TEXTURE-READ", request.pos,
                        "texture '" + file + "'" + (request.object.empty() ? "" : " of " + request.object) +
                            " cannot be used: " + why,
                        done);
    return nullptr;
  }

  Diagnostics& diagnostics;
  FileContents* contents;
  std::mutex mutex;
  std::vector<std::string> searchPath;
  std::optional<uint64_t> cacheLimit;
  std::string levelFolder;
  TextureReading reading;
  std::unique_ptr<TextureStore> owner;
  std::atomic<TextureStore*> store{nullptr};
  std::atomic<uint64_t> missingLookups{0};  // without a store
};

TextureSystem::TextureSystem(Diagnostics& diagnostics, FileContents* contents)
    : impl_(std::make_unique<Impl>(diagnostics, contents)) {}
TextureSystem::~TextureSystem() = default;

void TextureSystem::setSearchPath(std::vector<std::string> directories) {
  const std::lock_guard lock(impl_->mutex);
  impl_->searchPath = directories;
  if (impl_->store) impl_->owner->setSearchPath(std::move(directories));
}
void TextureSystem::setCacheLimit(uint64_t bytes) {
  const std::lock_guard lock(impl_->mutex);
  impl_->cacheLimit = bytes;
  if (impl_->store) impl_->owner->setCacheLimit(bytes);
}

void TextureSystem::setLevelFolder(std::string folder) {
  const std::lock_guard lock(impl_->mutex);
  impl_->levelFolder = folder;
  if (impl_->store) impl_->owner->setLevelFolder(std::move(folder));
}

void TextureSystem::setReading(TextureReading reading) {
  const std::lock_guard lock(impl_->mutex);
  impl_->reading = reading;
  if (impl_->store) impl_->owner->setReading(reading);
}

int TextureSystem::handle(const std::string& file, const TextureRequest& request) {
  if (file.empty()) return kNoTexture;
  TextureStore* const store = impl_->openFor(file, request, "lookups give the missing colour");
  return store ? store->handle(file, request) : kNoTexture;
}

void TextureSystem::lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t,
                           const float* radius, const TextureOptions& options, float* const rgba[4],
                           const float* const* axes) {
  lookup(handles, varying, n, s, t, radius, options, Part(), rgba, axes);
}
void TextureSystem::lookup(const int32_t* handles, bool varying, uint32_t n, const float* s, const float* t,
                           const float* radius, const TextureOptions& options, const Part& part, float* const rgba[4],
                           const float* const* axes) {
  if (TextureStore* const store = impl_->store)
    return store->lookup(handles, varying, n, s, t, radius, options, part, rgba, axes);
  // without a store there has been no file
  const texture::MissingColor missing(options);
  for (uint32_t i = 0; i < n; ++i) {
    float color[3];
    missing.at(s[i], t[i], radius[i], color);
    for (int c = 0; c < 3; ++c) rgba[c][i] = color[c];
    rgba[3][i] = options.missingAlpha;
  }
  impl_->missingLookups.fetch_add(n, std::memory_order_relaxed);
}

int TextureSystem::channels(int handle) const {
  TextureStore* const store = impl_->store;
  return store ? store->channels(handle) : 0;
}

std::string TextureSystem::find(const std::string& file, float s, float t) {
  std::string why;
  TextureStore* const store = file.empty() ? nullptr : impl_->open(why);
  if (store) return store->find(file, s, t);
  if (impl_->contents) impl_->contents->use("texture", file, std::vector<std::string>());
  return "";
}

bool TextureSystem::fact(const std::string& path, const std::string& name, int count, int* ints, float* floats,
                         std::string* text) {
  std::string why;
  TextureStore* const store = impl_->open(why);
  return store && store->fact(path, name, count, ints, floats, text);
}

const HostImage* TextureSystem::image(const std::string& file, int linearize, const TextureRequest& request) {
  TextureStore* const store = impl_->openFor(file, request, "no image is used");
  return store ? store->image(file, linearize, request) : nullptr;
}

TextureStatistics TextureSystem::statistics() const {
  TextureStore* const store = impl_->store;
  TextureStatistics r = store ? store->statistics() : TextureStatistics();
  r.lookups += impl_->missingLookups;
  r.missingLookups += impl_->missingLookups;
  return r;
}

namespace texture {

MakeTextureResult makeTexture(const std::string& input, const std::string& output, const MakeTextureOptions& options,
                              std::string& why) {
  const auto* const library = image::pictureLibrary<TextureCalls>(why);
  return library ? library->make(input, output, options, why) : MakeTextureResult::BadInput;
}

}  // namespace texture

}  // namespace kinora
