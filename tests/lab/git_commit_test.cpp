#include "lab/git_commit.h"

#include "folder.h"

namespace cxlab::lab {
namespace {

const std::string kOne(40, 'a'), kTwo(40, 'b');

class GitCommitTest : public FolderTest {};

TEST_F(GitCommitTest, IsThatOfTheBranchThatIsCheckedOut) {
  write("mine/.git/HEAD", "ref: refs/heads/feature/x\n");
  write("mine/.git/packed-refs",
        "# pack-refs with: peeled\n" + kOne + " refs/heads/main\n" + kTwo + " refs/heads/feature/x\n");
  write("mine/agent/clips/rules.clp", "");
  EXPECT_EQ(git_commit_of(path("mine/agent/clips")), kTwo) << "of a reference that is packed";
  write("mine/.git/refs/heads/feature/x", kOne + "\n");
  EXPECT_EQ(git_commit_of(path("mine/agent/clips")), kOne);
  write("mine/.git/HEAD", kTwo + "\n");
  EXPECT_EQ(git_commit_of(path("mine")), kTwo) << "without a branch";
}

TEST_F(GitCommitTest, IsThatOfAWorktree) {
  write("main/.git/worktrees/other/HEAD", "ref: refs/heads/other\n");
  write("main/.git/worktrees/other/commondir", "../..\n");
  write("main/.git/refs/heads/other", kOne + "\n");
  write("other/.git", "gitdir: " + path("main/.git/worktrees/other").string() + "\n");
  EXPECT_EQ(git_commit_of(path("other")), kOne);
}

TEST_F(GitCommitTest, IsEmptyWhereNothingIsCheckedOutAndForWhatIsNoCommit) {
  write("mine/.git/HEAD", "ref: refs/heads/main\n");
  EXPECT_EQ(git_commit_of(path("mine")), "") << "before the first commit";
  write("secret", kOne + "\n");
  for (const std::string head : {"ref: refs/../../../secret", "ref: ../../secret", "something else", ""}) {
    write("mine/.git/HEAD", head);
    EXPECT_EQ(git_commit_of(path("mine")), "") << head;
  }
  EXPECT_EQ(git_commit_of(path("nowhere")), "");
}

}  // namespace
}  // namespace cxlab::lab
