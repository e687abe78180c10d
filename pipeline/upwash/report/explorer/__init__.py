"""The explorer: one page on which a follower is dragged about behind its leader, and says what it saves there."""
