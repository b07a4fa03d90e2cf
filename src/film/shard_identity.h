// Which scene a part of a frame is of, as JSON inside it, and the comparison of two. Used by shard.cpp; what is read
// back comes from a file, and reading throws on JSON of the wrong shape.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "film/shard.h"

namespace kinora::film {

nlohmann::json inventoryToJson(const scene::Inventory& inventory);
scene::Inventory inventoryFromJson(const nlohmann::json& j);
nlohmann::json filesToJson(const std::vector<FileContents::Entry>& files);
std::vector<FileContents::Entry> filesFromJson(const nlohmann::json& j);

// "" when both are parts of one frame as far as scene and files go, else the first difference with the object's name.
std::string sceneDifference(const ShardInfo& before, const ShardInfo& part);

}  // namespace kinora::film
