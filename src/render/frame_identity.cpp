#include "render/frame_identity.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <system_error>

#include "base/text.h"
#include "render/version.h"

namespace kinora::render {

namespace {

// A whole path is one machine's: its last name stands for it.
std::string portable(const std::string& name) {
  const bool isWhole = name.find(':') == 1 || (!name.empty() && (name[0] == '/' || name[0] == '\\'));
  return isWhole ? name.substr(name.find_last_of("/\\") + 1) : name;
}

}  // namespace

void FrameIdentity::start(const scene::Scene& scene, FileContents& contents, const Registry& registry,
                          bool isEdited) {
  wait();
  if (!isEdited) primitives_ = {};
  files_ = contents.names();
  facts_ = {{"version of the program", "", digestOf(kVersion)}};
  std::set<std::string> named;
  for (const std::string& plugin : scene::pluginsOf(scene)) named.insert(lowerCase(plugin));
  for (const Descriptor* d : registry.all())
    if (const auto library = registry.libraryOf(*d); library && named.contains(lowerCase(d->name)))
      facts_.push_back({"library of the plug-in", d->name, *library});
  const auto makeAlone = [this, &scene, &contents, isEdited] {
    // one thread beside those that render
    tbb::task_arena alone(1);
    alone.execute([&] { make(scene, contents, isEdited); });
  };
  try {
    made_ = std::async(std::launch::async, makeAlone);
  } catch (const std::system_error&) {  // the process may have no more threads
    makeAlone();
  }
}

void FrameIdentity::make(const scene::Scene& scene, FileContents& contents, bool isEdited) {
  byName_.clear();
  for (FileContents::Entry& f : files_) {
    f.content = contents.contentOf(f.kind, f.name);
    facts_.push_back({f.kind, portable(f.name), f.content.value_or(Digest())});
    // what is not there is known by its name alone
    if (!f.content) continue;
    const auto [it, isNew] = byName_.try_emplace(f.name, *f.content);
    if (isNew) continue;
    Hasher both;
    both.digest(it->second);
    both.digest(*f.content);
    it->second = both.result();
  }
  std::sort(facts_.begin(), facts_.end());
  Hasher h;
  h.digest(scene::digestOf(scene, byName_, isEdited ? &primitives_ : nullptr));
  for (const Fact& f : facts_) {
    h.text(f.kind);
    h.text(f.name);
    h.digest(f.content);
  }
  digest_ = h.result();
}

void FrameIdentity::wait() const {
  if (made_.valid()) made_.wait();
}

void FrameIdentity::finish() {
  if (made_.valid()) made_.get();
}

std::string FrameIdentity::hash(bool mayWait) {
  if (!mayWait && made_.valid() && made_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return "";
  finish();
  return digest_.str();
}

scene::Inventory FrameIdentity::inventory(const scene::Scene& scene) {
  finish();
  // files first: that a texture is another one says more than that the object differs which shows it
  scene::Inventory all;
  for (const Fact& f : facts_) all.add(f.kind + (f.name.empty() ? "" : " \"" + f.name + "\""), f.content);
  scene::Inventory things = scene::inventoryOf(scene, byName_);
  std::move(things.things.begin(), things.things.end(), std::back_inserter(all.things));
  return all;
}

std::vector<FileContents::Entry> FrameIdentity::lateFiles(FileContents& contents) {
  finish();
  std::vector<FileContents::Entry> late;
  for (FileContents::Entry& f : contents.used())
    if (std::find(files_.begin(), files_.end(), f) == files_.end()) late.push_back(std::move(f));
  return late;
}

}  // namespace kinora::render
