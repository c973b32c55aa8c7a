#include "viz/web/item_store.hpp"

#include <utility>

namespace fusion_slam {

void ItemStore::set(Shelf& shelf, const std::string& key,
                    std::shared_ptr<const std::string> payload) {
  const auto [place, is_new] = shelf.items.try_emplace(key);
  Entry& entry = place->second;
  if (!is_new) {
    if (!payload && !entry.payload) return;
    if (payload && entry.payload && *payload == *entry.payload) return;
    shelf.by_version.erase(entry.version);
  } else if (!payload) {
    shelf.items.erase(place);
    return;
  }
  if (payload && !entry.payload) ++shelf.alive;
  if (!payload && entry.payload) --shelf.alive;
  entry.version = ++version_;
  entry.payload = std::move(payload);
  shelf.by_version[entry.version] = &place->first;
}

void ItemStore::put(Topic topic, const std::string& key, std::string payload) {
  auto shared = std::make_shared<const std::string>(std::move(payload));
  const std::lock_guard<std::mutex> lock(mutex_);
  set(shelf(topic), key, std::move(shared));
}

void ItemStore::remove(Topic topic, const std::string& key) {
  const std::lock_guard<std::mutex> lock(mutex_);
  set(shelf(topic), key, nullptr);
}

void ItemStore::remove_all(Topic topic) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (auto& [key, entry] : shelf(topic).items)
    if (entry.payload) set(shelf(topic), key, nullptr);
}

void ItemStore::clear() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++epoch_;
  for (Shelf& shelf : shelves_) shelf = Shelf();
}

std::vector<Item> ItemStore::next(Cursor* cursor, const TopicSet& wanted,
                                  std::size_t max_bytes) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (cursor->epoch != epoch_) *cursor = Cursor{epoch_, {}};
  std::vector<Item> items;
  std::size_t n_bytes = 0;
  for (std::size_t topic = 0; topic < kTopics && n_bytes < max_bytes; ++topic) {
    if (!wanted[topic]) continue;
    const Shelf& shelf = shelves_[topic];
    std::uint64_t& seen = cursor->seen[topic];
    const bool has_nothing = seen == 0;
    for (auto change = shelf.by_version.upper_bound(seen);
         change != shelf.by_version.end() && n_bytes < max_bytes; ++change) {
      seen = change->first;
      const auto& [key, entry] = *shelf.items.find(*change->second);
      if (has_nothing && !entry.payload) continue;  // it never had what is gone
      n_bytes += key.size() + (entry.payload ? entry.payload->size() : 0);
      items.push_back({static_cast<Topic>(topic), key, entry.payload});
    }
  }
  return items;
}

std::shared_ptr<const std::string> ItemStore::find(Topic topic, const std::string& key) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto item = shelf(topic).items.find(key);
  return item == shelf(topic).items.end() ? nullptr : item->second.payload;
}

std::size_t ItemStore::size(Topic topic) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return shelf(topic).alive;
}

}  // namespace fusion_slam
