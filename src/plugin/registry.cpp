#include "plugin/registry.h"

#include <dlfcn.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>

#include "base/file_contents.h"
#include "base/text.h"
#include "simd/dispatch.h"

namespace kinora {

namespace {
std::string lower(std::string_view s) { return lowerCase(std::string(s)); }
}  // namespace

struct Registry::Impl {
  std::vector<const Descriptor*> list;
  std::vector<std::string> path;
  std::map<std::string, bool> tried;  // files already opened: was anything in them of use?
  std::vector<void*> handles;
  std::map<const Descriptor*, Digest> libraries;
  mutable std::recursive_mutex mutex;

  const Descriptor* lookup(Kind kind, const std::string& key) const {
    for (const Descriptor* d : list)
      if (d->kind == kind && lower(d->name) == key) return d;
    return nullptr;
  }
};

Registry::Registry() : impl_(std::make_unique<Impl>()) { impl_->list = stockPlugins(); }

Registry::~Registry() {
  for (void* h : impl_->handles) dlclose(h);
}

void Registry::setPath(std::vector<std::string> directories) {
  std::lock_guard lock(impl_->mutex);
  impl_->path = std::move(directories);
}

void Registry::add(const Descriptor& plugin) {
  std::lock_guard lock(impl_->mutex);
  impl_->list.push_back(&plugin);
}

bool Registry::load(const std::string& file, Diagnostics& diagnostics, const SourcePos& pos) {
  std::lock_guard lock(impl_->mutex);
  if (const auto it = impl_->tried.find(file); it != impl_->tried.end()) return it->second;
  bool& isUsable = impl_->tried[file];  // false until all of it was looked at
  const auto refuse = [&](const std::string& why) {
    diagnostics.warning("PLUGIN-LOAD", pos, "plug-in library '" + file + "' cannot be used: " + why, "ignored",
                        "rebuild it against this Kinora's headers");
    return false;
  };
  void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) return refuse(dlerror());
  impl_->handles.push_back(handle);
  const auto get = reinterpret_cast<DescriptorFunction>(dlsym(handle, kDescriptorSymbol));
  if (!get) return refuse("it does not export " + std::string(kDescriptorSymbol));
  const std::optional<Digest> content = digestOfFile(file);
  uint32_t known = 0, added = 0;
  constexpr uint32_t kMostPerLibrary = 256;
  for (uint32_t i = 0; i < kMostPerLibrary; ++i) {
    const Descriptor* d = nullptr;
    try {
      d = get(i);
    } catch (...) {
      return refuse("exception while it was asked for its plug-ins");
    }
    if (!d) break;
    if (d->abiVersion != kAbiVersion)
      return refuse("it was built for plug-in interface " + std::to_string(d->abiVersion) + ", this is " +
                    std::to_string(kAbiVersion));
    if (d->descriptorBytes != sizeof(Descriptor) || !d->name || (d->paramCount && !d->params))
      return refuse("its descriptor is malformed");
    if (d->tableCount && !functionsFor(*d, 16)) return refuse("it has no function table that this CPU runs");
    if (impl_->lookup(d->kind, lower(d->name))) {
      diagnostics.warning(
          "PLUGIN-DUPLICATE", pos,
          "plug-in '" + std::string(d->name) + "' in '" + file + "' has the name of one already known",
          "the first one is used");
      ++known;
      continue;
    }
    impl_->list.push_back(d);
    if (content) impl_->libraries[d] = *content;
    ++added;
  }
  isUsable = added > 0;
  return isUsable || (known > 0 ? false : refuse("it declares no plug-in"));
}

const Descriptor* Registry::find(Kind kind, std::string_view name, Diagnostics& diagnostics, const SourcePos& pos) {
  std::lock_guard lock(impl_->mutex);
  const std::string key = lower(name);
  if (const Descriptor* d = impl_->lookup(kind, key)) return d;
  // a name from a scene is never a path
  if (key.empty() || key.find('/') != std::string::npos || key[0] == '.') return nullptr;
  for (const std::string& directory : impl_->path) {
    std::error_code ec;
    for (const auto& entry : std::filesystem::directory_iterator(directory, ec))
      if (entry.path().extension() == ".so" && lower(entry.path().stem().string()) == key) {
        load(entry.path().string(), diagnostics, pos);
        if (const Descriptor* d = impl_->lookup(kind, key)) return d;
      }
  }
  return nullptr;
}

void Registry::loadAll(Diagnostics& diagnostics) {
  std::lock_guard lock(impl_->mutex);
  for (const std::string& directory : impl_->path) {
    std::error_code ec;
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(directory, ec))
      if (entry.path().extension() == ".so") files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    for (const std::string& f : files) load(f, diagnostics, {});
  }
}

std::vector<const Descriptor*> Registry::all(Kind kind) const {
  std::vector<const Descriptor*> r;
  for (const Descriptor* d : all())
    if (d->kind == kind) r.push_back(d);
  return r;
}
std::vector<const Descriptor*> Registry::all() const {
  std::lock_guard lock(impl_->mutex);
  return impl_->list;
}

std::optional<Digest> Registry::libraryOf(const Descriptor& plugin) const {
  std::lock_guard lock(impl_->mutex);
  const auto it = impl_->libraries.find(&plugin);
  return it == impl_->libraries.end() ? std::nullopt : std::optional(it->second);
}

const char* nameOf(Kind kind) {
  static const char* const kNames[] = {"bxdf",          "pattern",      "light",    "lightfilter", "integrator",
                                       "projection",    "displacement", "volume",   "pixelfilter", "samplefilter",
                                       "displayfilter", "display",      "geometry", "hider"};
  return uint32_t(kind) < std::size(kNames) ? kNames[uint32_t(kind)] : "unknown kind";
}

const void* functionsFor(const Descriptor& d, uint32_t width, uint32_t* got) {
  const WidthTable* best = nullptr;
  for (uint32_t i = 0; i < d.tableCount; ++i) {
    const WidthTable& t = d.tables[i];
    if (t.width > width || (t.width > 8 && !cpuHasAvx512()) || !t.functions) continue;
    if (!best || t.width > best->width) best = &t;
  }
  // a plug-in built for wide only: any table gives the same bits
  if (!best)
    for (uint32_t i = 0; i < d.tableCount; ++i)
      if (d.tables[i].functions && (d.tables[i].width <= 8 || cpuHasAvx512())) best = &d.tables[i];
  if (got) *got = best ? best->width : 0;
  return best ? best->functions : nullptr;
}

}  // namespace kinora
