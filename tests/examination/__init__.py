"""The examination of the grader: wrong solutions made by machine, and wrong solutions as students write them."""
