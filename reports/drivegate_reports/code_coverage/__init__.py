"""The page of what runs reached of a candidate's code: its sources, line by line."""
