"""Records in words: tables, the HTML report, the gate and the leaderboard."""
