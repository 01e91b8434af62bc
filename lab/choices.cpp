#include "lab/choices.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>
#include <vector>

namespace cxlab::lab {

namespace {

Choice read_choice(const bus::MessageView& message) {
  Choice choice;
  choice.id = message.integer("id");
  choice.kind = message.text("kind");
  choice.who = message.text("who");
  choice.preferred = message.integer("preferred");
  const bus::MessageType& type = message.type();
  const auto each = [&](std::string_view name, auto& values, auto read) {
    const bus::Field& field = *type.find(name);
    values.reserve(message.size(field));
    for (std::size_t i = 0; i < message.size(field); ++i) values.push_back(read(field, i));
  };
  const auto real = [&](const bus::Field& field, std::size_t i) { return message.real(field, i); };
  each("options", choice.options, [&](const bus::Field& field, std::size_t i) { return message.text(field, i); });
  each("allowed", choice.allowed,
       [&](const bus::Field& field, std::size_t i) { return message.integer(field, i) != 0; });
  each("situation", choice.situation, real);
  each("features", choice.features, real);
  return choice;
}

}  // namespace

/// Keeps the choices that are open, and sends the answers.
class ChoiceEpisode::Chooser final : public QuietAgent {
 public:
  Chooser(SeatBus& bus, const ChoiceTopic& topic) : bus_(bus), made_(topic.name + "/made") {
    reads_ = bus_.read(topic.name, "cxlab_msgs/msg/Choice",
                       [this](const bus::MessageView& message) { open_.push_back(read_choice(message)); });
  }

  Status perceive() override { return reads_; }

  const Choice* first() const { return open_.empty() ? nullptr : &open_.front(); }

  Status answer(std::int64_t option) {
    auto made = bus_.make("cxlab_msgs/msg/ChoiceMade");
    if (!made) return made.error();
    made->view().set("id", open_.front().id).set("option", option);
    open_.pop_front();
    return bus_.publish(made_, "cxlab_msgs/msg/ChoiceMade", *std::move(made));
  }

 private:
  SeatBus& bus_;
  std::string made_;
  Status reads_;
  std::deque<Choice> open_;
};

Expected<std::unique_ptr<ChoiceEpisode>> ChoiceEpisode::load(PlayOptions options, Scenario scenario, ChoiceTopic topic,
                                                             const Host& host) {
  std::unique_ptr<ChoiceEpisode> episode(new ChoiceEpisode);
  options.seats.push_back({topic.seat, [&](SeatBus& bus) -> Expected<std::unique_ptr<Agent>> {
                             auto chooser = std::make_unique<Chooser>(bus, topic);
                             episode->chooser_ = chooser.get();
                             return std::unique_ptr<Agent>(std::move(chooser));
                           }});
  auto session = Session::load(options, std::move(scenario), host);
  if (!session) return session.error();
  episode->session_ = *std::move(session);
  return episode;
}

Expected<const Choice*> ChoiceEpisode::next_choice(const std::function<bool()>& pause) {
  if (!chooser_->first()) {
    const auto step = session_->step(kNever, [&] { return chooser_->first() || (pause && pause()); });
    if (!step) return step.error();
  }
  return chooser_->first();
}

Status ChoiceEpisode::play_on(std::span<ChoiceEpisode* const> episodes, std::size_t threads,
                              const std::function<bool()>& pause) {
  threads = std::clamp<std::size_t>(threads, 1, std::max<std::size_t>(episodes.size(), 1));
  std::vector<Status> ends(episodes.size());
  // Each thread has a share of the episodes. What it does not get to is taken by those that are ready.
  const auto begin_of = [&](std::size_t share) { return share * episodes.size() / threads; };
  std::vector<std::atomic<std::size_t>> next(threads);
  for (std::size_t share = 0; share < threads; ++share) next[share] = begin_of(share);
  const auto play = [&](std::size_t own) {
    for (std::size_t i = 0; i < threads; ++i) {
      const std::size_t share = (own + i) % threads;
      for (std::size_t at; (at = next[share]++) < begin_of(share + 1);)
        if (const auto choice = episodes[at]->next_choice(pause); !choice) ends[at] = choice.error();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t own = 1; own < threads; ++own) others.emplace_back(play, own);
    play(0);
  }
  const auto failed = std::ranges::find_if(ends, [](const Status& end) { return !end; });
  return failed == ends.end() ? Status() : *failed;
}

Status ChoiceEpisode::choose(std::int64_t option) {
  const Choice* choice = chooser_->first();
  if (!choice) return usage_error("found no open choice; call next_choice() first");
  const auto size = static_cast<std::int64_t>(choice->allowed.size());
  if (option < 0 || option >= size || !choice->allowed[static_cast<std::size_t>(option)])
    return usage_error("option " + std::to_string(option) + " of choice " + std::to_string(choice->id) + " (" +
                       choice->kind + ") may not be chosen; expected one that the mask allows, of " +
                       std::to_string(size));
  return chooser_->answer(option);
}

}  // namespace cxlab::lab
