#include "film/shard_identity.h"

#include <unordered_map>

#include "film/json_text.h"

namespace kinora::film {

using nlohmann::json;

// Names of fields repeat from thing to thing and stand in a table; digests are numbers.
json inventoryToJson(const scene::Inventory& inventory) {
  std::unordered_map<std::string, size_t> indexOf;
  json names = json::array(), things = json::array();
  for (const scene::Inventory::Thing& t : inventory.things) {
    json parts = json::array();
    for (const scene::Inventory::Part& p : t.parts) {
      const auto [it, isNew] = indexOf.try_emplace(p.name, indexOf.size());
      if (isNew) names.push_back(jsonOfText(p.name));
      parts.push_back(it->second);
      parts.push_back(p.digest);
    }
    json thing = json::array({jsonOfText(t.name), jsonOfText(t.place), t.digest, parts});
    if (t.count > 1) thing.insert(thing.end(), {json(t.count), jsonOfText(t.last)});
    things.push_back(std::move(thing));
  }
  return {{"names", names}, {"things", things}};
}

scene::Inventory inventoryFromJson(const json& j) {
  scene::Inventory inventory;
  const json& names = j.at("names");
  for (const json& t : j.at("things")) {
    scene::Inventory::Thing thing{textOfJson(t.at(0)), textOfJson(t.at(1)), 1, "", t.at(2).get<uint64_t>(), {}};
    const json& parts = t.at(3);
    for (size_t i = 0; i + 1 < parts.size(); i += 2)
      thing.parts.push_back({textOfJson(names.at(parts[i].get<size_t>())), parts[i + 1].get<uint32_t>()});
    if (t.size() > 4) {
      thing.count = t.at(4).get<uint32_t>();
      thing.last = textOfJson(t.at(5));
    }
    inventory.things.push_back(std::move(thing));
  }
  return inventory;
}

json filesToJson(const std::vector<FileContents::Entry>& files) {
  json list = json::array();
  for (const FileContents::Entry& f : files)
    list.push_back({jsonOfText(f.kind), jsonOfText(f.name),
                    f.content ? json::array({f.content->high, f.content->low}) : json::array()});
  return list;
}

std::vector<FileContents::Entry> filesFromJson(const json& j) {
  std::vector<FileContents::Entry> files;
  for (const json& f : j) {
    FileContents::Entry entry{textOfJson(f.at(0)), textOfJson(f.at(1)), {}};
    if (const json& content = f.at(2); !content.empty())
      entry.content = Digest{content.at(0).get<uint64_t>(), content.at(1).get<uint64_t>()};
    files.push_back(std::move(entry));
  }
  return files;
}

std::string sceneDifference(const ShardInfo& before, const ShardInfo& part) {
  if (before.sceneHash != part.sceneHash) {
    const std::string named = scene::firstDifference(before.inventory, part.inventory, "those before it", "this one");
    return named.empty() ? "scene hashes " + before.sceneHash + " and " + part.sceneHash : named;
  }
  for (const FileContents::Entry& a : before.lateFiles)
    for (const FileContents::Entry& b : part.lateFiles)
      if (a.kind == b.kind && a.name == b.name && a.content != b.content)
        return a.kind + " \"" + a.name + "\" differs";
  return "";
}

}  // namespace kinora::film
