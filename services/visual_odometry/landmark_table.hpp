// Landmarks by id, as a std::map, whose look-ups don't walk a tree: tracking asks for thousands a
// frame. Iteration is ascending in id. A plain value; not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace fusion_slam {

template <class Landmark>
class LandmarkTable {
 public:
  using Map = std::map<std::int64_t, Landmark>;

  LandmarkTable() = default;
  LandmarkTable(const LandmarkTable& other) : map_(other.map_) { index_all(); }
  LandmarkTable(LandmarkTable&& other) noexcept { swap(other); }
  LandmarkTable& operator=(LandmarkTable other) noexcept {
    swap(other);
    return *this;
  }
  ~LandmarkTable() = default;

  auto begin() const { return map_.begin(); }
  auto end() const { return map_.end(); }
  auto rbegin() const { return map_.rbegin(); }
  std::size_t size() const { return map_.size(); }
  bool empty() const { return map_.empty(); }

  // Null: no such. Ids are not negative. Valid until this landmark is erased.
  Landmark* find(std::int64_t id) {
    const auto page = static_cast<std::size_t>(id) / kPage;
    if (page >= pages_.size() || !pages_[page]) return nullptr;
    return pages_[page]->landmarks[static_cast<std::size_t>(id) % kPage];
  }
  const Landmark* find(std::int64_t id) const { return const_cast<LandmarkTable*>(this)->find(id); }
  Landmark& at(std::int64_t id) { return map_.at(id); }
  const Landmark& at(std::int64_t id) const { return map_.at(id); }

  // Nothing happens when the id is taken.
  void emplace(std::int64_t id, Landmark landmark) {
    if (find(id) == nullptr) index(id, &map_.emplace(id, std::move(landmark)).first->second);
  }
  Landmark& operator[](std::int64_t id) {
    if (find(id) == nullptr) emplace(id, {});
    return *find(id);
  }
  void erase(std::int64_t id) {
    if (map_.erase(id) > 0) index(id, nullptr);
  }

 private:
  // Ids are never given again: pages are small, so that one goes when its few landmarks have gone.
  static constexpr std::size_t kPage = 64;
  struct Page {
    std::array<Landmark*, kPage> landmarks{};  // into map_, whose nodes stay where they are
    std::size_t n = 0;                         // that are not null
  };

  void index(std::int64_t id, Landmark* landmark) {
    const auto page = static_cast<std::size_t>(id) / kPage;
    if (page >= pages_.size()) pages_.resize(page + 1);
    if (!pages_[page]) pages_[page] = std::make_unique<Page>();
    Landmark*& slot = pages_[page]->landmarks[static_cast<std::size_t>(id) % kPage];
    pages_[page]->n += (landmark != nullptr ? 1U : 0U);
    pages_[page]->n -= (slot != nullptr ? 1U : 0U);
    slot = landmark;
    if (pages_[page]->n == 0) pages_[page].reset();
  }
  void index_all() {
    for (auto& [id, landmark] : map_) index(id, &landmark);
  }
  void swap(LandmarkTable& other) noexcept {
    map_.swap(other.map_);
    pages_.swap(other.pages_);
  }

  Map map_;
  std::vector<std::unique_ptr<Page>> pages_;
};

}  // namespace fusion_slam
