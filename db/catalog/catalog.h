// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "calib/vocabulary/reference.h"
#include "calib/vocabulary/run.h"
#include "calib/vocabulary/segment.h"
#include "db/run/run_file.h"

namespace soak::db {

/// Who put an end to something, when and why.
struct EndRecord {
  std::string reason;
  std::string user;
  double utc_s = 0.0;
};

/// An entry of the register of references: one certificate. Entries are only ever added.
struct ReferenceRow {
  calib::Reference reference;
  std::string user;  ///< who entered it
  double entered_utc_s = 0.0;
  std::optional<EndRecord> retired = std::nullopt;    ///< the reference is not used any more
  std::optional<EndRecord> withdrawn = std::nullopt;  ///< the entry is wrong: it counts as never made
};

/// A unit that is measured in every campaign, so that the station itself can be judged by it.
struct CheckStandardRow {
  std::string check_standard_id = {};  ///< UUIDv7 of the record
  std::string unit;                    ///< serial number
  double since_utc_s = 0.0;
  std::string reason;
  std::string user;
  std::optional<EndRecord> ended = std::nullopt;
};

struct UnitRow {
  std::string serial;
  std::string type = "generic";
  std::int32_t epoch = 0;  ///< rises with each repair or re-flash
};

/// That the samples of a run were dropped, of all its units, to make room: its file goes, all else stays. A file that
/// is put back from a backup counts as if it had never gone.
struct SampleDrop {
  std::string run_id;
  std::string source;       ///< RunInfo::source of the file
  std::uint64_t bytes = 0;  ///< of the file
  std::string reason;
  std::string user;
  double utc_s = 0.0;
};

/// Whether a text is the purpose of a run: "calibration", "verification" or "diagnosis".
[[nodiscard]] bool is_purpose(std::string_view text);

/// One unit's part of one run. A run file may hold several units; each has its row here.
struct RunRow {
  std::string run_id;
  std::string unit;
  std::string campaign;
  std::string label;
  std::string procedure;
  std::string purpose = "calibration";  ///< what may be done with it: only calibration is fitted
  std::int32_t epoch = 0;
  double created_utc_s = 0.0;
  double clock_rate = 1.0;
  bool simulated = false;
  bool sealed = false;
  bool voided = false;         ///< by a void record of the whole run
  std::string file_name;       ///< relative to the folder `runs`
  std::string file_sha256;     ///< of the sealed file
  std::string content_sha256;  ///< RunFileReader::content_hash()
  calib::Site site;
  std::uint64_t rows = 0;
  double duration_s = 0.0;
  std::string cut_short = {};       ///< why it ended before its last visit; empty = it has all of them
  std::string continues = {};       ///< run id of the run that was cut short and goes on here; empty = none
  std::string numbers_sha256 = {};  ///< of all that the catalog holds of it but voids and drops; not read by add_run()
  std::optional<SampleDrop> samples_dropped = {};  ///< the last drop, where the file is gone; not read by add_run()
};

struct RunFilter {
  std::optional<std::string> unit;
  std::optional<std::string> campaign;
  std::optional<std::string> run;  ///< run id, unique prefix of one, or label
};

/// How many segments one unit's run has, and how many of them count no more.
struct SegmentCounts {
  std::string run_id;
  std::string unit;
  std::uint64_t recorded = 0;
  std::uint64_t withdrawn = 0;  ///< by void records
  std::uint64_t rejected = 0;   ///< not withdrawn, with a finding that rejects the segment or a sensor of it
};

/// What a void record withdraws: a whole run, one visit of it, or one segment. Records are only ever added.
struct VoidRecord {
  std::string run_id;
  std::string unit;
  std::optional<std::int32_t> visit;
  std::optional<std::string> position;  ///< with `visit`
  std::optional<std::int32_t> attempt;  ///< with `visit` and `position`
  std::string reason;
  std::string user;
  double utc_s = 0.0;
};

/// One version of a unit's model. `document` is the JSON of the whole model; the other fields are for finding it.
struct ModelRow {
  std::string unit;
  std::int32_t version = 0;  ///< 1, 2, ... per unit
  std::int32_t epoch = 0;
  double created_utc_s = 0.0;
  std::string document;
};

/// Where a model came from.
struct ModelOrigin {
  std::string software;       ///< that fitted it: "0.2.0"
  std::string inputs_sha256;  ///< of all that the fit took
  std::string user = {};      ///< who fitted it; not read when it is entered
};

/// A version of a unit's model without its document.
struct ModelHead {
  std::string unit;
  std::int32_t version = 0;
  std::int32_t epoch = 0;
  double created_utc_s = 0.0;
  std::string state;  ///< "fitted", "verified", "released" or "withdrawn"
};

/// That a model came into a state. Rows are only ever added; the last one counts.
struct ModelStateRow {
  std::string unit;
  std::int32_t version = 0;
  std::string state;  ///< as in ModelHead
  std::string reason;
  std::string user;
  double utc_s = 0.0;
};

/// What a verification of a model said.
struct VerificationRow {
  std::string unit;
  std::int32_t model_version = 0;
  double utc_s = 0.0;
  std::string user;
  std::string verdict;   ///< "pass", "marginal", "fail" or "info"
  std::string document;  ///< JSON
};

/// What was found missing in a model: the JSON that `soak gap find` printed.
struct GapReportRow {
  std::string unit;
  std::int32_t model_version = 0;
  double created_utc_s = 0.0;
  std::string document;
};

/// An exported calibration file.
struct CalibrationRow {
  std::string unit;
  std::int32_t model_version = 0;
  double created_utc_s = 0.0;
  std::string format;
  std::string sha256;
  std::string path;
  std::string user = {};  ///< who has it; empty: whom act_as() named
};

/// The journal of a campaign that this station carries out: what was planned and how far it came.
struct CampaignRow {
  std::string name;
  std::string procedure;
  std::string document;           ///< JSON: procedure, plan, units and slots (docs/file-formats.md)
  std::string state = "running";  ///< "running", "paused", "interrupted", "finished", "aborted" or "failed"
  std::string reason;             ///< of that state, for people
  double created_utc_s = 0.0;
  double updated_utc_s = 0.0;  ///< of the last change of state
};

/// A step of the plan that came to its end.
struct StepRow {
  std::string campaign;
  std::int32_t index = 0;    ///< in the plan's list of steps
  std::int32_t attempt = 0;  ///< how often it was begun before
  double started_utc_s = 0.0;
  double ended_utc_s = 0.0;
  std::string outcome;  ///< "done", "skipped", "failed"
  std::string text;     ///< what there is to say of it
  std::string run_id;   ///< of the run file that it wrote to; empty = none
};

struct RunRecord;

/// An entry of the event log: who did what when.
struct EventRow {
  double utc_s = 0.0;
  std::string kind;
  std::string subject;  ///< unit, run, campaign... that it is about
  std::string text;
  std::string user = {};          ///< who did it; empty = not known (the station by itself)
  std::int64_t number = 0;        ///< 1, 2, 3, ... at this station; not read when it is entered
  std::string chain_sha256 = {};  ///< of this event and all before it; not read when it is entered
};

/// Which events are asked for: those that are like everything that is given.
struct EventFilter {
  std::optional<std::string> kind;
  std::optional<std::string> subject;
  std::optional<std::string> user;
  std::optional<double> from_utc_s;
  std::optional<double> to_utc_s;               ///< that moment itself not
  std::optional<std::int64_t> before;           ///< only smaller numbers
  std::size_t most = 0;                         ///< the newest so many
  std::vector<std::string> subjects = {};       ///< about any of these; none: whatever they are about
  std::vector<std::string> without_kinds = {};  ///< not of these kinds
};

/// The event log as a chain (docs/file-formats.md).
struct EventChain {
  std::uint64_t events = 0;
  std::string end_sha256;  ///< chain_sha256 of the last event; empty where there is none

  bool operator==(const EventChain&) const = default;
};

/// The station's catalog `station.db`: what exists, statistics, models and an append-only log. Several processes may
/// use it at once (WAL, busy time-out, short IMMEDIATE transactions). No row is deleted.
class Catalog {
 public:
  /// Opens the catalog of a data folder, creating folder and file where absent and migrating an older version forward.
  /// Where the folder cannot be written (an archive), all that reads works and all that writes is refused.
  /// Refuses a file of a newer version or of a development version (bad_input), a damaged one (corrupt), a folder that
  /// cannot be written (internal, with the reason: read-only, full).
  [[nodiscard]] static base::Result<Catalog> open(const std::filesystem::path& data_folder);
  /// Opens a catalog that nobody writes (a backup) without changing it: all that writes is refused. Fails as open()
  /// does, and (bad_input) where there is none, or one of another version than kSchemaVersion.
  [[nodiscard]] static base::Result<Catalog> open_unchanged(const std::filesystem::path& data_folder);
  Catalog(Catalog&&) noexcept;
  Catalog& operator=(Catalog&&) noexcept;
  ~Catalog();

  /// Schema version that this program writes.
  static constexpr int kSchemaVersion = 3;

  [[nodiscard]] const std::filesystem::path& data_folder() const;
  /// Whether the catalog can only be read: an archive.
  [[nodiscard]] bool read_only() const;
  /// Who works with the catalog from here on: events that name no user are by this one.
  void act_as(std::string_view user);
  [[nodiscard]] std::filesystem::path run_file_path(const RunRow& run) const;

  /// Writes the state of the catalog into a new file, on the disk when it returns; others go on working with the
  /// catalog meanwhile. Refuses a file that exists (bad_input); leaves none behind if it fails.
  [[nodiscard]] base::Status copy_to(const std::filesystem::path& file) const;

  /// Runs `work`, whose calls of this catalog become one transaction: all of them are kept if it succeeds, none if not.
  /// Other processes wait meanwhile: keep it short.
  [[nodiscard]] base::Status all_or_nothing(const std::function<base::Status()>& work);

  /// The unit, added with type `type` and epoch 0 where it is new.
  [[nodiscard]] base::Result<UnitRow> ensure_unit(std::string_view serial, std::string_view type);
  /// The same where `user` (not empty) asks for it: a unit that is new is in the event log, as "unit_added".
  [[nodiscard]] base::Result<UnitRow> add_unit(std::string_view serial, std::string_view type, std::string_view user);
  [[nodiscard]] base::Result<std::optional<UnitRow>> unit(std::string_view serial) const;
  [[nodiscard]] base::Result<std::vector<UnitRow>> units() const;
  /// Starts the unit's next epoch (after a repair or re-flash) and logs who did it and why. Refuses (bad_input) an
  /// unknown unit, and no reason or user.
  [[nodiscard]] base::Result<UnitRow> begin_epoch(std::string_view serial, std::string_view reason,
                                                  std::string_view user);

  /// The campaign's procedure; adds the campaign where it is new. Refuses another procedure for an existing one.
  [[nodiscard]] base::Status ensure_campaign(std::string_view name, std::string_view procedure);
  [[nodiscard]] base::Result<std::vector<std::string>> campaigns() const;

  /// Adds a campaign with its journal. Refuses (bad_input) a name whose campaign has runs or a journal, a second
  /// campaign while one is open, and an unknown state.
  [[nodiscard]] base::Status begin_campaign(const CampaignRow& campaign);
  /// The journal of a campaign; nothing for one that has none.
  [[nodiscard]] base::Result<std::optional<CampaignRow>> campaign(std::string_view name) const;
  /// The campaign in state "running" or "paused", if there is one.
  [[nodiscard]] base::Result<std::optional<CampaignRow>> open_campaign() const;
  /// The campaign with a journal that was begun last, whatever its state.
  [[nodiscard]] base::Result<std::optional<CampaignRow>> last_campaign() const;
  /// Changes the state and logs it, with the user who asked for it, if one did. Refuses (bad_input) a campaign without
  /// journal, an unknown state, and a second open campaign.
  [[nodiscard]] base::Status set_campaign_state(std::string_view name, std::string_view state, std::string_view reason,
                                                std::string_view user = {});
  /// Enters a step. After success it survives a killed process and a loss of power. Refuses (bad_input) a campaign
  /// without journal and an attempt of a step that is entered already.
  [[nodiscard]] base::Status complete_step(const StepRow& step);
  /// The steps of a campaign in the order in which they were entered; none for an unknown campaign.
  [[nodiscard]] base::Result<std::vector<StepRow>> completed_steps(std::string_view campaign) const;

  /// Adds a sealed run of one unit with the statistics and findings of its segments, all or nothing, and logs it.
  /// Refuses a second run with the same campaign, unit and label.
  [[nodiscard]] base::Status add_run(const RunRow& run, const std::vector<calib::Segment>& segments);
  /// All that the catalog holds of one unit's run but voids and drops (run_record.h). Fails as check_numbers() does.
  [[nodiscard]] base::Result<RunRecord> run_record(std::string_view run_id, std::string_view unit) const;
  /// Enters a sealed run as run_record() of another catalog gave it, to the last bit, all or nothing, and logs it. Unit
  /// and campaign must be there. Refuses (bad_input) a run of that id, or of that campaign, unit and label, that is
  /// there already, and a record of another version; (corrupt) one whose rows do not have the digest that it states.
  [[nodiscard]] base::Status add_run_record(const RunRecord& record);
  [[nodiscard]] base::Result<std::vector<RunRow>> runs(const RunFilter& filter) const;
  /// Whether the file of a sealed run is there and holds, byte for byte, what was sealed; fails (corrupt), naming the
  /// file. Reads all of it, of the runs of several units in one file once. Of a run whose samples were dropped there is
  /// nothing to check.
  [[nodiscard]] base::Status check_run_file(const RunRow& run) const;
  /// The samples of a run. Fails as RunFileReader::open() does; refuses (bad_input) a run whose samples were dropped,
  /// saying when, by whom and why.
  [[nodiscard]] base::Result<RunFileReader> open_run_file(const RunRow& run) const;
  /// Segments of one unit's run that no void record withdraws, in the order of time, with their findings; with their
  /// blocks if asked. Those with findings that reject them are among them. Refuses (corrupt) a run whose numbers in the
  /// catalog are not those that were stored, and any run where the tables of runs, voids, units or sample drops are
  /// not.
  [[nodiscard]] base::Result<std::vector<calib::Segment>> segments(std::string_view run_id, std::string_view unit,
                                                                   bool with_blocks) const;

  /// The same segments with those that void records withdraw, without blocks. Fails as segments() does.
  [[nodiscard]] base::Result<std::vector<calib::Segment>> recorded_segments(std::string_view run_id,
                                                                            std::string_view unit) const;
  /// Of all runs that have segments, in no order that means anything.
  [[nodiscard]] base::Result<std::vector<SegmentCounts>> segment_counts() const;

  /// Whether the catalog's numbers of a run are those that were stored; fails (corrupt), naming the run.
  [[nodiscard]] base::Status check_numbers(const RunRow& run) const;

  /// Notes and logs that the samples of a run are dropped; to remove the file afterwards is the caller's part. Refuses
  /// (bad_input) an unknown run, one that is not sealed, and no reason or user.
  [[nodiscard]] base::Status add_sample_drop(const SampleDrop& drop);

  [[nodiscard]] base::Status add_void(const VoidRecord& record);
  [[nodiscard]] base::Result<std::vector<VoidRecord>> voids(std::string_view run_id) const;

  /// Stores the document as the unit's next model version and returns its number. `make_document` gets that number.
  /// `origin`: where it came from, if that is known.
  [[nodiscard]] base::Result<std::int32_t> add_model(std::string_view unit, std::int32_t epoch, double created_utc_s,
                                                     const std::function<std::string(std::int32_t)>& make_document,
                                                     const std::optional<ModelOrigin>& origin = {});
  /// Where a version came from; nothing where that is not known.
  [[nodiscard]] base::Result<std::optional<ModelOrigin>> model_origin(std::string_view unit,
                                                                      std::int32_t version) const;
  /// All versions of a unit, or of all units, in the order of serial number and version.
  [[nodiscard]] base::Result<std::vector<ModelHead>> models(const std::optional<std::string>& unit = {}) const;
  /// Brings a model into a state and logs it. Refuses (bad_input) an unknown model, an empty reason or user, and a step
  /// that is none of: fitted to verified, verified to released, verified back to fitted, and any but withdrawn to
  /// withdrawn.
  [[nodiscard]] base::Status set_model_state(const ModelStateRow& row);
  /// The changes of state of a model in their order; the first is that it was fitted.
  [[nodiscard]] base::Result<std::vector<ModelStateRow>> model_history(std::string_view unit,
                                                                       std::int32_t version) const;
  /// Stores what a verification said of a model, and logs it. Refuses (bad_input) an unknown model.
  [[nodiscard]] base::Status add_verification(const VerificationRow& row);
  /// The verifications of a model in the order in which they were stored.
  [[nodiscard]] base::Result<std::vector<VerificationRow>> verifications(std::string_view unit,
                                                                         std::int32_t version) const;
  /// A version, or the newest where `version` is absent. Refuses (corrupt) one whose document is not as it was stored.
  [[nodiscard]] base::Result<std::optional<ModelRow>> model(std::string_view unit,
                                                            std::optional<std::int32_t> version = {}) const;
  /// Enters a certificate into the register and returns its record id; the row's own id is not read. Refuses
  /// (bad_input) an empty text, numbers that are not finite or negative, a due date that is not after the issue, and an
  /// entry that is there already, word for word, neither withdrawn nor retired.
  [[nodiscard]] base::Result<std::string> add_reference(const ReferenceRow& row);
  /// All entries in the order in which they were made, superseded and retired ones too.
  [[nodiscard]] base::Result<std::vector<ReferenceRow>> references() const;
  /// Refuses (bad_input) an unknown entry, one that is retired already, and no reason or user.
  [[nodiscard]] base::Status retire_reference(std::string_view record_id, const EndRecord& end);
  /// Notes that an entry is wrong. Refuses (bad_input) an unknown entry, one that is withdrawn already, and no reason
  /// or user.
  [[nodiscard]] base::Status withdraw_reference(std::string_view record_id, const EndRecord& end);
  /// Stores a waiver as it was signed; its signature is the caller's to check. Refuses an unknown entry.
  [[nodiscard]] base::Status add_waiver(const calib::Waiver& waiver);
  /// In the order in which they were stored.
  [[nodiscard]] base::Result<std::vector<calib::Waiver>> waivers() const;
  /// Notes which entries a campaign, which must exist, is measured with. What is noted already is not noted again.
  [[nodiscard]] base::Status add_campaign_references(std::string_view campaign,
                                                     const std::vector<calib::ReferenceUse>& uses);
  /// Each entry once, in the order of the first note, with the waiver that was noted last, if there is one. Of a waiver
  /// that is gone from its table nothing is left but its number. Fails (corrupt) where an entry of the register is
  /// gone.
  [[nodiscard]] base::Result<std::vector<calib::ReferenceUse>> campaign_references(std::string_view campaign) const;
  /// Names of the campaigns that an entry was noted for.
  [[nodiscard]] base::Result<std::vector<std::string>> campaigns_of_reference(std::string_view record_id) const;

  /// Makes a unit a check standard and returns the record's id; the row's own id and end are not read. Refuses
  /// (bad_input) an unknown unit, one that is a check standard, and no reason or user.
  [[nodiscard]] base::Result<std::string> add_check_standard(const CheckStandardRow& row);
  /// Refuses (bad_input) an unknown or ended record, and no reason or user.
  [[nodiscard]] base::Status end_check_standard(std::string_view check_standard_id, const EndRecord& end);
  /// All records in the order in which they were made, ended ones too.
  [[nodiscard]] base::Result<std::vector<CheckStandardRow>> check_standards() const;

  /// Refuses (bad_input) a report on a model that the catalog does not have.
  [[nodiscard]] base::Status add_gap_report(const GapReportRow& report);
  /// All reports of a unit in the order in which they were stored.
  [[nodiscard]] base::Result<std::vector<GapReportRow>> gap_reports(std::string_view unit) const;

  [[nodiscard]] base::Status add_calibration(const CalibrationRow& calibration);
  [[nodiscard]] base::Status log_event(const EventRow& event);
  /// In the order in which they were entered.
  [[nodiscard]] base::Result<std::vector<EventRow>> events() const;
  /// Some of them, the newest first.
  [[nodiscard]] base::Result<std::vector<EventRow>> find_events(const EventFilter& filter) const;
  /// The kinds of all events, each once, in the order of the alphabet.
  [[nodiscard]] base::Result<std::vector<std::string>> event_kinds() const;
  /// Who stands in the events, each once, in the order of the alphabet.
  [[nodiscard]] base::Result<std::vector<std::string>> event_users() const;
  /// Follows the chain of the event log; fails (corrupt), naming the first event that was changed or is missing.
  [[nodiscard]] base::Result<EventChain> check_events() const;
  /// SQLite's integrity check and foreign keys, the schema, the seals of the tables and the chain of the event log:
  /// corrupt, with the first finding. What check_numbers() checks is not checked.
  [[nodiscard]] base::Status verify() const;

 private:
  struct Impl;
  explicit Catalog(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// A run file in the data folder that no row of the catalog names: its writer came to an end before it could enter it,
/// or is still at work.
struct OrphanRunFile {
  std::filesystem::path path;
  bool sealed = false;
  std::optional<RunInfo> info;     ///< what the file says of itself; absent where it cannot be read
  std::vector<std::string> units;  ///< serial numbers of its streams, each once
  std::string problem;             ///< why it cannot be read
};

/// The orphans among `*.soakrun` in the folder `runs`, in the order of their names, which is that of time. Other names
/// are passed over: an import that was killed leaves `*.soakrun.tmp`, which may also belong to one at work; nothing
/// removes it.
[[nodiscard]] base::Result<std::vector<OrphanRunFile>> orphan_run_files(const Catalog& catalog);

}  // namespace soak::db
